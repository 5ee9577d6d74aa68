#include "common/policy/onnx/onnx_graph.h"

#include "absl/strings/str_cat.h"

namespace sinew::policy::internal {
namespace {

onnx::AttributeProto& AddAttribute(onnx::NodeProto& node,
                                   absl::string_view name,
                                   onnx::AttributeProto::AttributeType type) {
  onnx::AttributeProto* attribute = node.add_attribute();
  attribute->set_name(std::string(name));
  attribute->set_type(type);
  return *attribute;
}

void Describe(onnx::ValueInfoProto& value, const std::string& name,
              int64_t width, absl::string_view doc) {
  value.set_name(name);
  value.set_doc_string(std::string(doc));
  onnx::TypeProto::Tensor* tensor = value.mutable_type()->mutable_tensor_type();
  tensor->set_elem_type(onnx::TensorProto::FLOAT);
  tensor->mutable_shape()->add_dim()->set_dim_param("batch");
  tensor->mutable_shape()->add_dim()->set_dim_value(width);
}

void AddEntry(onnx::TensorProto& tensor, const char* key, std::string value) {
  onnx::StringStringEntryProto* entry = tensor.add_external_data();
  entry->set_key(key);
  entry->set_value(std::move(value));
}

}  // namespace

onnx::NodeProto& OnnxGraph::Node(absl::string_view op,
                                 absl::Span<const std::string> inputs,
                                 const std::string& output) {
  onnx::NodeProto* node = graph_.add_node();
  node->set_op_type(std::string(op));
  node->set_name(output);
  for (const std::string& input : inputs) node->add_input(input);
  node->add_output(output);
  return *node;
}

std::string OnnxGraph::Float(const std::string& name, float value) {
  onnx::TensorProto* tensor = graph_.add_initializer();
  tensor->set_name(name);
  tensor->set_data_type(onnx::TensorProto::FLOAT);
  tensor->add_float_data(value);
  return name;
}

std::string OnnxGraph::Int64s(const std::string& name,
                              absl::Span<const int64_t> values) {
  onnx::TensorProto* tensor = graph_.add_initializer();
  tensor->set_name(name);
  tensor->set_data_type(onnx::TensorProto::INT64);
  tensor->add_dims(static_cast<int64_t>(values.size()));
  for (const int64_t value : values) tensor->add_int64_data(value);
  return name;
}

void OnnxGraph::Weight(const std::string& name, absl::Span<const int64_t> shape,
                       absl::string_view file, const TensorLocation& location) {
  if (!weights_.insert(name).second) return;
  onnx::TensorProto* tensor = graph_.add_initializer();
  tensor->set_name(name);
  tensor->set_data_type(onnx::TensorProto::FLOAT);
  for (const int64_t extent : shape) tensor->add_dims(extent);
  tensor->set_data_location(onnx::TensorProto::EXTERNAL);
  AddEntry(*tensor, "location", std::string(file));
  AddEntry(*tensor, "offset", absl::StrCat(location.offset));
  AddEntry(*tensor, "length", absl::StrCat(location.length));
}

void OnnxGraph::Input(const std::string& name, int64_t width,
                      absl::string_view doc) {
  Describe(*graph_.add_input(), name, width, doc);
}

void OnnxGraph::Output(const std::string& name, int64_t width,
                       absl::string_view doc) {
  Describe(*graph_.add_output(), name, width, doc);
}

void SetInt(onnx::NodeProto& node, absl::string_view name, int64_t value) {
  AddAttribute(node, name, onnx::AttributeProto::INT).set_i(value);
}

void SetInts(onnx::NodeProto& node, absl::string_view name,
             absl::Span<const int64_t> values) {
  onnx::AttributeProto& attribute =
      AddAttribute(node, name, onnx::AttributeProto::INTS);
  for (const int64_t value : values) attribute.add_ints(value);
}

void SetFloat(onnx::NodeProto& node, absl::string_view name, float value) {
  AddAttribute(node, name, onnx::AttributeProto::FLOAT).set_f(value);
}

}  // namespace sinew::policy::internal
