// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace m100::lab::logs {

/// One variable of a MAT-file, or a field of one: a real matrix, a scalar structure, or neither (text, cells, complex
/// numbers and structure arrays are listed but not read).
struct MatVariable {
  std::string name;
  bool is_matrix = false;
  std::array<std::size_t, 2> dims{};
  std::string_view bytes;     ///< data of a matrix, column by column
  std::uint32_t storage = 0;  ///< MATLAB's code for the stored number type
  std::vector<MatVariable> fields;

  std::size_t length() const { return dims[0] > dims[1] ? dims[0] : dims[1]; }
  std::size_t width() const { return dims[0] > dims[1] ? dims[1] : dims[0]; }
  /// Row `row` (from 0) of a matrix whose longer side is time. Precondition: is_matrix, row < width().
  std::vector<double> row(std::size_t row) const;
  /// nullptr: there is no such field.
  const MatVariable* field(std::string_view wanted) const;
};

/// A MATLAB 5 file, little endian, with or without compression, or a MATLAB 7.3 file (mat_hdf5.h). Memory and time are
/// at most a constant times its size; unpacked data are limited to 64 MiB plus 64 times its size. A size in the file
/// beyond its bytes counts as damage.
class MatFile {
 public:
  /// @throws InputError: not a MAT-file that can be read, big endian, no readable variable.
  explicit MatFile(const std::string& file);
  const std::vector<MatVariable>& variables() const { return variables_; }
  /// "MAT 5" or "MAT 7.3".
  const std::string& version() const { return version_; }

 private:
  void read_elements(std::string_view bytes);
  std::string_view unpacked(std::string_view packed);
  void require_variables(const std::string& file) const;

  std::string version_ = "MAT 5";
  std::string bytes_;
  std::deque<std::string> unpacked_;  ///< memory of the variables' views
  std::size_t bytes_left_ = 0;
  std::vector<MatVariable> variables_;
};

}  // namespace m100::lab::logs
