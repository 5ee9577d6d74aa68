#include "sim/import/formats/testing/binary_fbx.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/check.h"

namespace sinew::import::testing {
namespace {

struct Node {
  std::string name;
  std::vector<std::string> values;  // as written, strings with their quotes
  bool is_array = false;            // of what `values` has
  bool has_block = false;
  std::vector<Node> children;
};

std::vector<std::string> ValuesOf(absl::string_view text) {
  std::vector<std::string> values;
  text = absl::StripAsciiWhitespace(text);
  while (!text.empty()) {
    // A comma in a string is none between values.
    const size_t from = text[0] == '"' ? text.find('"', 1) : 0;
    const size_t end = std::min(text.find(',', from), text.size());
    values.emplace_back(absl::StripAsciiWhitespace(text.substr(0, end)));
    text =
        absl::StripAsciiWhitespace(text.substr(std::min(end + 1, text.size())));
  }
  return values;
}

// The lines from `*at` to the end of the block, as nodes.
std::vector<Node> NodesOf(const std::vector<absl::string_view>& lines,
                          size_t* at) {
  std::vector<Node> nodes;
  for (; *at < lines.size(); ++*at) {
    absl::string_view line = absl::StripAsciiWhitespace(lines[*at]);
    if (line.empty() || line[0] == ';') continue;
    if (line == "}") return nodes;
    const size_t colon = line.find(':');
    SINEW_CHECK(colon != line.npos) << line;
    Node node;
    node.name = std::string(line.substr(0, colon));
    line.remove_prefix(colon + 1);
    node.has_block = absl::ConsumeSuffix(&line, "{");
    node.values = ValuesOf(line);
    if (node.has_block) {
      ++*at;
      node.children = NodesOf(lines, at);
      SINEW_CHECK(*at < lines.size()) << node.name << ": not closed";
    }
    if (node.values.size() == 1 && node.values[0][0] == '*') {
      SINEW_CHECK(node.children.size() == 1) << node.name;
      node.is_array = true;
      node.has_block = false;
      node.values = std::move(node.children[0].values);
      node.children.clear();
    }
    nodes.push_back(std::move(node));
  }
  return nodes;
}

template <typename Number>
void Append(Number number, std::string* bytes) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(raw));  // the file is little endian, as this
  bytes->append(raw, sizeof(raw));         // machine
}

double NumberOf(const std::string& value) {
  double number = 0;
  SINEW_CHECK(absl::SimpleAtod(value, &number)) << value;
  return number;
}

int64_t IntegerOf(const std::string& value) {
  int64_t number = 0;
  SINEW_CHECK(absl::SimpleAtoi(value, &number)) << value;
  return number;
}

char ArrayType(absl::string_view name) {
  if (name == "KeyTime") return 'l';
  if (name == "KeyValueFloat" || name == "KeyAttrDataFloat") return 'f';
  if (absl::StrContains(name, "Index") || name == "Materials" ||
      absl::StartsWith(name, "KeyAttr")) {
    return 'i';
  }
  return 'd';
}

// Of a property's values, by the type that it states itself.
char PropertyType(absl::string_view type) {
  if (type == "int" || type == "enum" || type == "bool" || type == "Integer" ||
      type == "Visibility Inheritance") {
    return 'I';
  }
  if (type == "KTime" || type == "ULongLong") return 'L';
  return 'D';
}

char TypeOf(const Node& node, size_t value, absl::string_view parent) {
  const std::string& text = node.values[value];
  if (text[0] == '"') return 'S';
  if (text == "T" || text == "F" || text == "Y") return 'C';
  if (node.name == "P") {
    return PropertyType(
        absl::StripSuffix(absl::StripPrefix(node.values.at(1), "\""), "\""));
  }
  const bool names_object = node.name == "C" || node.name == "Document" ||
                            node.name == "RootNode" || node.name == "Node" ||
                            parent == "Objects";
  if (names_object) return 'L';
  if (absl::StrContains(text, '.') || node.name == "Default" ||
      absl::StrContains(node.name, "Acuracy")) {
    return 'D';
  }
  return 'I';
}

// "Class::name" of the text is name, 0, 1, Class.
std::string StringOf(absl::string_view quoted) {
  const absl::string_view text = quoted.substr(1, quoted.size() - 2);
  const size_t colons = text.find("::");
  if (colons == text.npos) return std::string(text);
  return absl::StrCat(text.substr(colons + 2), std::string("\0\1", 2),
                      text.substr(0, colons));
}

class Writer {
 public:
  explicit Writer(const BinaryFbxOptions& options) : options_(options) {
    bytes_.append("Kaydara FBX Binary  \0\x1a\0", 23);
    Append(options.version, &bytes_);
  }

  std::string Write(const std::vector<Node>& nodes) {
    for (const Node& node : nodes) AddNode(node, "");
    AddEnd();
    return std::move(bytes_);
  }

 private:
  bool Wide() const { return options_.version >= 7500; }
  size_t EndSize() const { return Wide() ? 25 : 13; }
  void AddEnd() { bytes_.append(EndSize(), '\0'); }

  void AddOffset(uint64_t offset) {
    if (Wide()) return Append(offset, &bytes_);
    SINEW_CHECK(offset <= std::numeric_limits<uint32_t>::max());
    Append(static_cast<uint32_t>(offset), &bytes_);
  }

  void SetOffset(size_t at, uint64_t offset) {
    std::memcpy(&bytes_[at], &offset, Wide() ? 8 : 4);
  }

  void AddNode(const Node& node, absl::string_view parent) {
    const std::string properties =
        node.is_array ? Array(node) : Properties(node, parent);
    const size_t start = bytes_.size();
    AddOffset(0);  // where it ends, set below
    AddOffset(node.is_array ? 1 : node.values.size());
    AddOffset(properties.size());
    Append(static_cast<uint8_t>(node.name.size()), &bytes_);
    bytes_ += node.name;
    bytes_ += properties;
    for (const Node& child : node.children) AddNode(child, node.name);
    if (node.has_block) AddEnd();
    SetOffset(start, bytes_.size());
  }

  std::string Properties(const Node& node, absl::string_view parent) const {
    std::string bytes;
    for (size_t i = 0; i < node.values.size(); ++i) {
      const char type = TypeOf(node, i, parent);
      bytes += type;
      switch (type) {
        case 'S': {
          const std::string text = StringOf(node.values[i]);
          Append(static_cast<uint32_t>(text.size()), &bytes);
          bytes += text;
          break;
        }
        case 'C':
          Append(static_cast<uint8_t>(node.values[i] != "F"), &bytes);
          break;
        case 'L':
          Append(IntegerOf(node.values[i]), &bytes);
          break;
        case 'I':
          Append(static_cast<int32_t>(IntegerOf(node.values[i])), &bytes);
          break;
        default:
          Append(NumberOf(node.values[i]), &bytes);
      }
    }
    return bytes;
  }

  std::string Array(const Node& node) const {
    const char type = ArrayType(node.name);
    std::string numbers;
    for (const std::string& value : node.values) {
      if (type == 'l') Append(IntegerOf(value), &numbers);
      if (type == 'i') {
        Append(static_cast<int32_t>(IntegerOf(value)), &numbers);
      }
      if (type == 'f') Append(static_cast<float>(NumberOf(value)), &numbers);
      if (type == 'd') Append(NumberOf(value), &numbers);
    }
    if (options_.deflate) numbers = Deflated(numbers);
    std::string bytes(1, type);
    Append(static_cast<uint32_t>(node.values.size()), &bytes);
    Append(static_cast<uint32_t>(options_.deflate), &bytes);
    Append(static_cast<uint32_t>(numbers.size()), &bytes);
    return bytes + numbers;
  }

  static std::string Deflated(const std::string& bytes) {
    uLongf size = compressBound(bytes.size());
    std::string deflated(size, '\0');
    SINEW_CHECK(compress(reinterpret_cast<Bytef*>(deflated.data()), &size,
                         reinterpret_cast<const Bytef*>(bytes.data()),
                         bytes.size()) == Z_OK);
    deflated.resize(size);
    return deflated;
  }

  const BinaryFbxOptions options_;
  std::string bytes_;
};

}  // namespace

std::string BinaryFbx(absl::string_view text, const BinaryFbxOptions& options) {
  const std::vector<absl::string_view> lines = absl::StrSplit(text, '\n');
  size_t at = 0;
  const std::vector<Node> nodes = NodesOf(lines, &at);
  SINEW_CHECK(at == lines.size()) << "line " << at << ": a block too many ends";
  return Writer(options).Write(nodes);
}

}  // namespace sinew::import::testing
