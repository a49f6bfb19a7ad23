// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/mat_file.h"

#include <zlib.h>
#include <utility>

#include <algorithm>
#include <optional>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/formats/mat_hdf5.h"
#include "host_tests/lab/logs/formats/read_number.h"
#include "host_tests/lab/whole_file.h"

// MATLAB 5: a header of 128 bytes, then elements {uint32 type, uint32 bytes, data to the next multiple of 8}; the tag
// itself may hold up to four bytes of data. A matrix (14) consists of the elements flags, sizes, name and numbers. A
// structure has, instead of the numbers, the length of its field names, the names, and one matrix for each field. Type
// 15 is an element that zlib has compressed.

namespace m100::lab::logs {
namespace {

constexpr std::size_t kHeadBytes = 128;
constexpr std::size_t kExpansion = 64;
constexpr std::size_t kSmall = std::size_t{64} << 20U;
constexpr int kDeepest = 32;
constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kPacked = 15;
constexpr std::uint32_t kStructure = 2;  // of the classes
constexpr std::uint32_t kFirstNumeric = 6;
constexpr std::uint32_t kLastNumeric = 15;
constexpr std::uint32_t kComplex = 0x800;

std::uint32_t word(std::string_view bytes, std::size_t at) { return read_number<std::uint32_t>(bytes.data() + at); }

struct Element {
  std::uint32_t type = 0;
  std::string_view data;
};

/// Removes and returns the next element. nullopt: there is no complete one.
std::optional<Element> next(std::string_view& bytes) {
  if (bytes.size() < 8) {
    return std::nullopt;
  }
  const std::uint32_t first = word(bytes, 0);
  if (first > 0xFFFFU) {  // data in the tag
    const std::size_t size = first >> 16U;
    if (size > 4) {
      return std::nullopt;
    }
    const Element out{first & 0xFFFFU, bytes.substr(4, size)};
    bytes.remove_prefix(8);
    return out;
  }
  const auto size = static_cast<std::size_t>(word(bytes, 4));
  if (size > bytes.size() - 8) {
    return std::nullopt;
  }
  const Element out{first, bytes.substr(8, size)};
  const std::size_t whole = first == kPacked ? size : (size + 7) / 8 * 8;
  bytes.remove_prefix(std::min(bytes.size(), 8 + whole));
  return out;
}

/// How numbers of a storage are read; one of no bytes holds no numbers.
struct Stored {
  std::size_t bytes = 0;
  double (*read)(const char*) = &read_as<double>;
};

const Stored& stored(std::uint32_t storage) {
  static constexpr std::array<Stored, 14> kStored{{{},
                                                   {1, &read_as<std::int8_t>},
                                                   {1, &read_as<std::uint8_t>},
                                                   {2, &read_as<std::int16_t>},
                                                   {2, &read_as<std::uint16_t>},
                                                   {4, &read_as<std::int32_t>},
                                                   {4, &read_as<std::uint32_t>},
                                                   {4, &read_as<float>},
                                                   {},
                                                   {8, &read_as<double>},
                                                   {},
                                                   {},
                                                   {8, &read_as<std::int64_t>},
                                                   {8, &read_as<std::uint64_t>}}};
  return kStored[storage < kStored.size() ? storage : 0];
}

MatVariable matrix_of(std::string_view bytes, int depth);

void read_fields(std::string_view bytes, int depth, MatVariable& out) {
  const auto length = next(bytes);
  const auto names = next(bytes);
  if (!length || !names || length->data.size() < 4 || word(length->data, 0) == 0) {
    return;
  }
  const auto each = static_cast<std::size_t>(word(length->data, 0));
  for (std::size_t at = 0; at + each <= names->data.size(); at += each) {
    const auto content = next(bytes);
    if (!content) {
      return;
    }
    const std::string_view name = names->data.substr(at, each);
    MatVariable field = content->type == kMatrix ? matrix_of(content->data, depth + 1) : MatVariable{};
    field.name = name.substr(0, name.find('\0'));
    out.fields.push_back(std::move(field));
  }
}

void read_numbers(std::string_view bytes, MatVariable& out) {
  const auto numbers = next(bytes);
  if (!numbers || stored(numbers->type).bytes == 0 || out.dims[0] == 0 || out.dims[1] == 0) {
    return;
  }
  const std::size_t count = numbers->data.size() / stored(numbers->type).bytes;
  out.is_matrix = out.dims[0] <= count / out.dims[1];
  out.storage = numbers->type;
  out.bytes = numbers->data;
}

/// The variable of a matrix element; one that cannot be understood has no value.
MatVariable matrix_of(std::string_view bytes, int depth) {
  MatVariable out;
  const auto flags = next(bytes);
  const auto sizes = next(bytes);
  const auto name = next(bytes);
  if (!flags || !sizes || !name || flags->data.size() < 4 || sizes->data.size() != 8 || depth > kDeepest) {
    return out;
  }
  out.name = std::string(name->data);
  out.dims = {word(sizes->data, 0), word(sizes->data, 4)};
  const std::uint32_t kind = word(flags->data, 0) & 0xFFU;
  if (kind == kStructure && out.dims[0] == 1 && out.dims[1] == 1) {
    read_fields(bytes, depth, out);
  } else if (kind >= kFirstNumeric && kind <= kLastNumeric && (word(flags->data, 0) & kComplex) == 0) {
    read_numbers(bytes, out);
  }
  return out;
}

}  // namespace

std::vector<double> MatVariable::row(std::size_t row) const {
  const bool time_is_second = dims[1] >= dims[0];
  const auto& [each, read] = stored(storage);
  std::vector<double> values(length());
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t index = time_is_second ? row + k * dims[0] : k + row * dims[0];
    values[k] = read(bytes.data() + index * each);
  }
  return values;
}

const MatVariable* MatVariable::field(std::string_view wanted) const {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const MatVariable& f) { return f.name == wanted; });
  return found == fields.end() ? nullptr : &*found;
}

MatFile::MatFile(const std::string& file) : bytes_(whole_file(file)) {
  const std::string_view all = bytes_;
  if (is_mat_7_3(all)) {
    variables_ = read_mat_7_3(file, all, unpacked_, kSmall + kExpansion * bytes_.size());
    version_ = "MAT 7.3";
    require_variables(file);
    return;
  }
  if (all.size() < kHeadBytes || (all.substr(126, 2) != "IM" && all.substr(126, 2) != "MI")) {
    throw InputError(file, 0, "", "is not a MAT-file of version 5 that can be read");
  }
  if (all.substr(126, 2) == "MI") {
    throw InputError(file, 0, "", "is a MAT-file of a big-endian machine: save it again with -v7");
  }
  bytes_left_ = kSmall + kExpansion * bytes_.size();
  read_elements(all.substr(kHeadBytes));
  require_variables(file);
}

void MatFile::require_variables(const std::string& file) const {
  if (variables_.empty()) {
    throw InputError(file, 0, "", "holds no variable that can be read");
  }
}

void MatFile::read_elements(std::string_view bytes) {
  while (const auto element = next(bytes)) {
    std::string_view inside = element->type == kPacked ? unpacked(element->data) : std::string_view();
    const auto packed = element->type == kPacked ? next(inside) : std::nullopt;
    const Element& variable = packed ? *packed : *element;
    if (variable.type == kMatrix) {
      MatVariable read = matrix_of(variable.data, 0);
      if (!read.name.empty()) {
        variables_.push_back(std::move(read));
      }
    }
  }
}

/// Unpacks zlib data; returns the intact beginning if the data are damaged or exceed the bytes left.
std::string_view MatFile::unpacked(std::string_view packed) {
  constexpr std::size_t kStep = std::size_t{1} << 16U;
  std::string out;
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) {
    return {};
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // zlib's signature; it only reads
  stream.avail_in = static_cast<uInt>(packed.size());
  int answer = Z_OK;
  while (answer == Z_OK && out.size() + kStep <= bytes_left_) {
    const std::size_t before = out.size();
    out.resize(before + kStep);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + before);
    stream.avail_out = static_cast<uInt>(kStep);
    answer = inflate(&stream, Z_NO_FLUSH);
    out.resize(before + kStep - stream.avail_out);
  }
  inflateEnd(&stream);
  bytes_left_ -= std::min(bytes_left_, out.size());
  unpacked_.push_back(std::move(out));
  return unpacked_.back();
}

}  // namespace m100::lab::logs
