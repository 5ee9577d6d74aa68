#include "common/policy/safetensors.h"

#include <cmath>
#include <cstring>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/policy/safetensors_header.h"
#include "common/status_macros.h"
#include "nlohmann/json.hpp"

namespace sinew {
namespace {

template <typename T>
absl::Span<const T> View(const std::string& data) {
  return absl::MakeConstSpan(reinterpret_cast<const T*>(data.data()),
                             data.size() / sizeof(T));
}

template <typename T>
HostTensor Make(v1::DataType dtype, std::vector<int64_t> shape,
                absl::Span<const T> values) {
  HostTensor tensor;
  tensor.dtype = dtype;
  tensor.shape = std::move(shape);
  tensor.data.assign(reinterpret_cast<const char*>(values.data()),
                     values.size() * sizeof(T));
  SINEW_CHECK(tensor.num_elements() == static_cast<int64_t>(values.size()))
      << "shape has " << tensor.num_elements() << " elements, found "
      << values.size();
  return tensor;
}

// Index of the first element that is not finite; -1 if all are.
template <typename T>
int64_t FirstNonFinite(absl::Span<const T> values) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) return static_cast<int64_t>(i);
  }
  return -1;
}

std::string HeaderText(const TensorMap& tensors,
                       const std::map<std::string, std::string>& metadata) {
  // Metadata first, then tensors by name: one order for equal maps.
  nlohmann::ordered_json header = nlohmann::ordered_json::object();
  if (!metadata.empty()) header["__metadata__"] = metadata;
  int64_t at = 0;
  for (const auto& [name, tensor] : tensors) {
    const int64_t end = at + static_cast<int64_t>(tensor.data.size());
    nlohmann::ordered_json& entry = header[name];
    entry["dtype"] = std::string(internal::SafetensorsTypeName(tensor.dtype));
    entry["shape"] = tensor.shape;
    entry["data_offsets"] = {at, end};
    at = end;
  }
  return header.dump(-1, ' ', /*ensure_ascii=*/false,
                     nlohmann::json::error_handler_t::replace);
}

}  // namespace

int64_t HostTensor::num_elements() const {
  int64_t count = 1;
  for (const int64_t extent : shape) count *= extent;
  return count;
}

absl::Span<const float> HostTensor::float32() const {
  SINEW_CHECK(dtype == v1::DATA_TYPE_FLOAT32) << "dtype " << dtype;
  return View<float>(data);
}

absl::Span<float> HostTensor::mutable_float32() {
  SINEW_CHECK(dtype == v1::DATA_TYPE_FLOAT32) << "dtype " << dtype;
  return absl::MakeSpan(reinterpret_cast<float*>(data.data()),
                        data.size() / sizeof(float));
}

absl::Span<const double> HostTensor::float64() const {
  SINEW_CHECK(dtype == v1::DATA_TYPE_FLOAT64) << "dtype " << dtype;
  return View<double>(data);
}

HostTensor HostTensor::Float32(std::vector<int64_t> shape,
                               absl::Span<const float> values) {
  return Make(v1::DATA_TYPE_FLOAT32, std::move(shape), values);
}

HostTensor HostTensor::Float64(std::vector<int64_t> shape,
                               absl::Span<const double> values) {
  return Make(v1::DATA_TYPE_FLOAT64, std::move(shape), values);
}

HostTensor HostTensor::Zeros(std::vector<int64_t> shape) {
  HostTensor tensor;
  tensor.shape = std::move(shape);
  tensor.data.assign(tensor.num_elements() * sizeof(float), '\0');
  return tensor;
}

std::string SerializeSafetensors(
    const TensorMap& tensors,
    const std::map<std::string, std::string>& metadata) {
  for (const auto& [name, tensor] : tensors) {
    SINEW_CHECK(!name.empty() && name != "__metadata__") << name;
    SINEW_CHECK(tensor.num_elements() * internal::DataTypeSize(tensor.dtype) ==
                static_cast<int64_t>(tensor.data.size()))
        << "tensor " << name << " has " << tensor.data.size() << " bytes";
  }
  std::string header = HeaderText(tensors, metadata);
  header.resize((header.size() + 7) / 8 * 8, ' ');
  const uint64_t length = header.size();
  std::string bytes(sizeof(length), '\0');
  std::memcpy(bytes.data(), &length, sizeof(length));
  size_t total = bytes.size() + header.size();
  for (const auto& [name, tensor] : tensors) total += tensor.data.size();
  bytes.reserve(total);
  bytes += header;
  for (const auto& [name, tensor] : tensors) bytes += tensor.data;
  return bytes;
}

absl::StatusOr<TensorMap> ParseSafetensors(absl::string_view bytes,
                                           absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(SafetensorsView view, ViewSafetensors(bytes, source));
  TensorMap tensors;
  for (auto& [name, tensor] : view.tensors) {
    tensors[name] = {.dtype = tensor.dtype,
                     .shape = std::move(tensor.shape),
                     .data = std::string(tensor.data)};
  }
  return tensors;
}

bool TensorView::aligned() const {
  return reinterpret_cast<uintptr_t>(data.data()) % alignof(float) == 0;
}

absl::Span<const float> TensorView::float32() const {
  SINEW_CHECK(dtype == v1::DATA_TYPE_FLOAT32) << "dtype " << dtype;
  SINEW_CHECK(aligned()) << "float32 at an odd address";
  return absl::MakeConstSpan(reinterpret_cast<const float*>(data.data()),
                             data.size() / sizeof(float));
}

absl::StatusOr<SafetensorsView> ViewSafetensors(absl::string_view bytes,
                                                absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(internal::SafetensorsLayout layout,
                         internal::ParseSafetensorsLayout(bytes, source));
  const absl::string_view data = bytes.substr(layout.data_offset);
  SafetensorsView view;
  view.metadata = std::move(layout.metadata);
  for (internal::SafetensorsEntry& entry : layout.entries) {
    view.tensors[std::move(entry.name)] = {
        .dtype = entry.dtype,
        .shape = std::move(entry.shape),
        .data = data.substr(entry.begin, entry.end - entry.begin)};
  }
  return view;
}

std::map<std::string, TensorView> ViewTensors(const TensorMap& tensors) {
  std::map<std::string, TensorView> views;
  for (const auto& [name, tensor] : tensors) {
    views[name] = {
        .dtype = tensor.dtype, .shape = tensor.shape, .data = tensor.data};
  }
  return views;
}

absl::StatusOr<std::map<std::string, TensorLocation>> LocateSafetensors(
    absl::string_view bytes, absl::string_view source) {
  SINEW_ASSIGN_OR_RETURN(const internal::SafetensorsLayout layout,
                         internal::ParseSafetensorsLayout(bytes, source));
  std::map<std::string, TensorLocation> locations;
  for (const internal::SafetensorsEntry& entry : layout.entries) {
    locations[entry.name] = {.offset = layout.data_offset + entry.begin,
                             .length = entry.end - entry.begin};
  }
  return locations;
}

absl::Status CheckFinite(const TensorMap& tensors, absl::string_view source) {
  for (const auto& [name, tensor] : tensors) {
    int64_t bad = -1;
    if (tensor.dtype == v1::DATA_TYPE_FLOAT32) {
      bad = FirstNonFinite(tensor.float32());
    } else if (tensor.dtype == v1::DATA_TYPE_FLOAT64) {
      bad = FirstNonFinite(tensor.float64());
    }
    if (bad >= 0) {
      return absl::InvalidArgumentError(absl::StrCat(
          source, ": tensor \"", name, "\": element ", bad, " is not finite"));
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew
