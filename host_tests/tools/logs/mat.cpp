// SPDX-License-Identifier: BSD-3-Clause
#include <matio.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "host_tests/tools/input_error.h"
#include "host_tests/tools/logs/raw_log.h"

namespace m100::tools::logs {
namespace {

struct CloseMat {
  void operator()(mat_t* mat) const { Mat_Close(mat); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

/// A path cut at its dots, and the row index behind the last name (1-based; 0: none).
struct Path {
  std::vector<std::string> parts;
  std::size_t row = 0;
};

template <typename T>
double element(const matvar_t* variable, std::size_t index) {
  return static_cast<double>(static_cast<const T*>(variable->data)[index]);
}

/// Reads one element whatever number type the file stores.
using Getter = double (*)(const matvar_t*, std::size_t);
Getter getter_of(matio_classes type) {
  switch (type) {
    case MAT_C_DOUBLE:
      return &element<double>;
    case MAT_C_SINGLE:
      return &element<float>;
    case MAT_C_INT8:
      return &element<std::int8_t>;
    case MAT_C_UINT8:
      return &element<std::uint8_t>;
    case MAT_C_INT16:
      return &element<std::int16_t>;
    case MAT_C_UINT16:
      return &element<std::uint16_t>;
    case MAT_C_INT32:
      return &element<std::int32_t>;
    case MAT_C_UINT32:
      return &element<std::uint32_t>;
    case MAT_C_INT64:
      return &element<std::int64_t>;
    case MAT_C_UINT64:
      return &element<std::uint64_t>;
    default:
      return nullptr;
  }
}

bool is_numeric(const matvar_t* variable) {
  return variable != nullptr && variable->rank == 2 && variable->data != nullptr && variable->isComplex == 0 &&
         getter_of(variable->class_type) != nullptr;
}

std::size_t length_of(const matvar_t* variable) { return std::max(variable->dims[0], variable->dims[1]); }
std::size_t width_of(const matvar_t* variable) { return std::min(variable->dims[0], variable->dims[1]); }

/// Row `row` (0-based) of a matrix whose longer side is time.
std::vector<double> row_of(const matvar_t* variable, std::size_t row) {
  const bool time_is_second = variable->dims[1] >= variable->dims[0];
  const Getter get = getter_of(variable->class_type);
  std::vector<double> values(length_of(variable));
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] = get(variable, time_is_second ? row + k * variable->dims[0] : k + row * variable->dims[0]);
  }
  return values;
}

/// Whole numbers that mostly go up by one.
bool counts(const std::vector<double>& numbers) {
  std::size_t ones = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (numbers[k] != std::round(numbers[k])) {
      return false;
    }
    ones += k > 0 && numbers[k] - numbers[k - 1] == 1.0 ? 1U : 0U;
  }
  return numbers.size() > 2 && 2 * ones > numbers.size();
}

class MatLog final : public RawLog {
 public:
  explicit MatLog(const std::string& file) : RawLog(file), mat_(Mat_Open(file.c_str(), MAT_ACC_RDONLY)) {
    Mat_LogInitFunc(nullptr, [](int, char*) {});  // its complaints would be a second, unclear line
    if (!mat_) {
      throw InputError(file, 0, "", "is not a MAT-file that can be read");
    }
    while (matvar_t* variable = Mat_VarReadNext(mat_.get())) {
      variables_.emplace_back(variable);
    }
    if (variables_.empty()) {
      throw InputError(file, 0, "", "holds no variable");
    }
  }

  std::vector<std::string> names() const override {
    std::vector<std::string> all;
    for (const auto& variable : variables_) {
      list(variable.get(), variable->name, all);
    }
    return all;
  }

  RawColumn column(const std::string& name, const std::string& asked_by) const override {
    const Path path = parse(name);
    const matvar_t* parent = nullptr;
    const matvar_t* variable = find(path.parts, parent);
    if (!is_numeric(variable)) {
      throw InputError(file(), 0, name,
                       (variable == nullptr ? "no such variable" : "is not a real matrix") +
                           std::string(" (wanted for ") + asked_by + "); there are: " + nearest_names(names(), name));
    }
    const std::size_t width = width_of(variable);
    if ((path.row == 0 && width != 1) || path.row > width) {
      throw InputError(file(), 0, name,
                       "has " + std::to_string(width) + " rows; write [1] to [" + std::to_string(width) + "]");
    }
    RawColumn column{.values = row_of(variable, path.row == 0 ? 0 : path.row - 1), .time_s = {}, .sequence = {}};
    for (std::size_t k = 0; k < column.values.size(); ++k) {
      if (!std::isfinite(column.values[k])) {
        throw InputError(file(), static_cast<long>(k) + 1, name,
                         "sample " + std::to_string(k + 1) + " is not a finite number");
      }
    }
    column.sequence = counter_beside(parent);
    return column;
  }

 private:
  Path parse(const std::string& name) const {
    Path path;
    std::string rest = name;
    if (!rest.empty() && rest.back() == ']') {
      const std::size_t open = rest.find('[');
      const char* begin = rest.data() + open + 1;
      const char* end = rest.data() + rest.size() - 1;
      if (open == std::string::npos || std::from_chars(begin, end, path.row).ptr != end || path.row == 0) {
        throw InputError(file(), 0, name, "the row in brackets is a number from 1");
      }
      rest.resize(open);
    }
    for (std::size_t begin = 0; begin <= rest.size();) {
      const std::size_t dot = std::min(rest.find('.', begin), rest.size());
      path.parts.push_back(rest.substr(begin, dot - begin));
      begin = dot + 1;
    }
    return path;
  }

  const matvar_t* find(const std::vector<std::string>& parts, const matvar_t*& parent) const {
    const matvar_t* at = nullptr;
    for (const auto& variable : variables_) {
      if (parts.front() == variable->name) {
        at = variable.get();
      }
    }
    for (std::size_t i = 1; i < parts.size() && at != nullptr; ++i) {
      parent = at;
      at = at->class_type == MAT_C_STRUCT && at->dims[0] * at->dims[1] == 1 ? field(at, parts[i].c_str()) : nullptr;
    }
    return at;
  }

  // matio takes non-const pointers for reading, too.
  static const matvar_t* field(const matvar_t* structure, const char* name) {
    return Mat_VarGetStructFieldByName(const_cast<matvar_t*>(structure), name, 0);
  }

  /// Message counters go by a few names; one beside a column in the same struct counts that stream's messages.
  static std::vector<double> counter_beside(const matvar_t* structure) {
    if (structure == nullptr) {
      return {};
    }
    for (const char* name : {"i", "seq", "sequence"}) {
      const matvar_t* counter = field(structure, name);
      if (!is_numeric(counter) || width_of(counter) != 1) {
        continue;
      }
      std::vector<double> numbers = row_of(counter, 0);
      if (counts(numbers)) {
        return numbers;
      }
    }
    return {};
  }

  void list(const matvar_t* variable, const std::string& path, std::vector<std::string>& all) const {
    if (variable->class_type == MAT_C_STRUCT && variable->dims[0] * variable->dims[1] == 1) {
      const unsigned count = Mat_VarGetNumberOfFields(const_cast<matvar_t*>(variable));
      char* const* fields = Mat_VarGetStructFieldnames(variable);
      for (unsigned i = 0; i < count; ++i) {
        list(field(variable, fields[i]), path + "." + fields[i], all);
      }
    } else if (is_numeric(variable)) {
      const std::size_t width = width_of(variable);
      for (std::size_t row = 1; row <= width; ++row) {
        all.push_back(width == 1 ? path : path + "[" + std::to_string(row) + "]");
      }
    }
  }

  std::unique_ptr<mat_t, CloseMat> mat_;
  std::vector<std::unique_ptr<matvar_t, FreeVariable>> variables_;
};

}  // namespace

std::unique_ptr<RawLog> open_mat(const std::string& file) { return std::make_unique<MatLog>(file); }

}  // namespace m100::tools::logs
