// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/mat_hdf5.h"

#include <cstdint>

#ifdef M100_MATIO
#include <matio.h>
#endif

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/formats/read_number.h"

namespace m100::lab::logs {
namespace {

constexpr std::size_t kHdf5At = 512;
constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";

std::uint64_t word(std::string_view bytes, std::size_t at) {
  return at + sizeof(std::uint64_t) <= bytes.size() ? read_number<std::uint64_t>(bytes.data() + at) : 0;
}

/// The size that the file should have according to its superblock; 0: that cannot be read. It is the third address of
/// the superblock, whose addresses begin at its byte 24 in version 0, 28 in version 1, 12 in versions 2 and 3.
std::uint64_t declared_end(std::string_view bytes) {
  if (bytes.size() < kHdf5At + 64 || bytes.substr(kHdf5At, kSignature.size()) != kSignature) {
    return 0;
  }
  const auto version = static_cast<unsigned char>(bytes[kHdf5At + 8]);
  const std::size_t addresses = kHdf5At + (version == 0 ? 24U : version == 1 ? 28U : 12U);
  const std::uint64_t base = word(bytes, addresses);
  const std::uint64_t end = word(bytes, addresses + 16);
  return version > 3 || base > kHdf5At ? 0 : end;
}

#ifdef M100_MATIO
class Reader {
 public:
  Reader(std::deque<std::string>& memory, std::size_t room) : memory_(memory), bytes_left_(room) {}

  /// The variable `from`, whose data have been read. One that cannot be used has no value.
  MatVariable variable(const matvar_t& from, int depth) {
    constexpr int kMaxDepth = 32;
    MatVariable out;
    out.name = from.name == nullptr ? "" : from.name;
    if (from.rank != 2 || from.data == nullptr || depth > kMaxDepth) {
      return out;
    }
    out.dims = {from.dims[0], from.dims[1]};
    if (from.class_type == MAT_C_STRUCT && out.dims[0] == 1 && out.dims[1] == 1) {
      const unsigned count = Mat_VarGetNumberOfFields(const_cast<matvar_t*>(&from));  // libmatio only reads it
      auto* const* const fields = static_cast<matvar_t* const*>(from.data);
      for (unsigned i = 0; i < count; ++i) {
        if (fields[i] != nullptr) {
          out.fields.push_back(variable(*fields[i], depth + 1));
        }
      }
    } else if (from.class_type >= MAT_C_DOUBLE && from.class_type <= MAT_C_UINT64 && from.isComplex == 0) {
      take(from, out);
    }
    return out;
  }

  /// Bytes that the data of this variable would take, from its sizes alone.
  static std::size_t bytes_of(const matvar_t& from, int depth) {
    constexpr std::size_t kTooMany = ~std::size_t{0} / 2;
    std::size_t bytes = 8;
    for (int i = 0; i < from.rank; ++i) {
      bytes = from.dims[i] != 0 && bytes > kTooMany / from.dims[i] ? kTooMany : bytes * from.dims[i];
    }
    if (from.class_type == MAT_C_STRUCT && from.data != nullptr && depth < 8) {
      const unsigned count = Mat_VarGetNumberOfFields(const_cast<matvar_t*>(&from));
      auto* const* const fields = static_cast<matvar_t* const*>(from.data);
      for (unsigned i = 0; i < count && bytes < kTooMany; ++i) {
        bytes += fields[i] == nullptr ? 0 : bytes_of(*fields[i], depth + 1);
      }
    }
    return bytes;
  }

  std::size_t room() const { return bytes_left_; }

 private:
  void take(const matvar_t& from, MatVariable& out) {
    if (from.dims[0] == 0 || from.dims[1] == 0 || from.nbytes > bytes_left_ || from.data_size <= 0 ||
        from.nbytes / static_cast<std::size_t>(from.data_size) < from.dims[0] * from.dims[1]) {
      return;
    }
    bytes_left_ -= from.nbytes;
    memory_.emplace_back(static_cast<const char*>(from.data), from.nbytes);
    out.bytes = memory_.back();
    out.storage = static_cast<std::uint32_t>(from.data_type);
    out.is_matrix = true;
  }

  std::deque<std::string>& memory_;
  std::size_t bytes_left_;
};
#endif

}  // namespace

bool is_mat_7_3(std::string_view head) {
  return head.starts_with("MATLAB 7.3") || head.substr(std::min(kHdf5At, head.size()), kSignature.size()) == kSignature;
}

std::vector<MatVariable> read_mat_7_3(const std::string& file, std::string_view bytes, std::deque<std::string>& memory,
                                      std::size_t room) {
  const std::uint64_t end = declared_end(bytes);
  if (end == 0 || end > bytes.size()) {
    throw InputError(file, 0, "",
                     "is a MATLAB 7.3 file (HDF5) that is cut off or damaged: copy it again, or save it with -v7");
  }
#ifdef M100_MATIO
  mat_t* const mat = Mat_Open(file.c_str(), MAT_ACC_RDONLY);
  if (mat == nullptr) {
    throw InputError(file, 0, "", "is a MATLAB 7.3 file (HDF5) that cannot be read: save it with -v7");
  }
  Reader reader(memory, room);
  std::vector<MatVariable> out;
  for (matvar_t* one = Mat_VarReadNextInfo(mat); one != nullptr; one = Mat_VarReadNextInfo(mat)) {
    if (Reader::bytes_of(*one, 0) <= reader.room() && Mat_VarReadDataAll(mat, one) == 0) {
      out.push_back(reader.variable(*one, 0));
    }
    Mat_VarFree(one);
  }
  Mat_Close(mat);
  return out;
#else
  static_cast<void>(memory);
  static_cast<void>(room);
  throw InputError(
      file, 0, "",
      "is a MATLAB 7.3 file (HDF5), which this build cannot read: save it with -v7, or build with libmatio");
#endif
}

}  // namespace m100::lab::logs
