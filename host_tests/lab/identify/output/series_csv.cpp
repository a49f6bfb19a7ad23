// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/series_csv.h"

#include <fstream>

#include "host_tests/lab/input_error.h"

namespace m100::lab::identify {

void write_series(const IdentifyResult& result, const std::string& file) {
  const Figures& figures = result.figures;
  std::ofstream out(file);
  out.precision(9);
  out << "t_s,validation";
  for (const Series& series : figures.series) {
    out << "," << series.name;
  }
  out << "\n";
  for (std::size_t k = 0; k < figures.t_s.size(); ++k) {
    out << figures.t_s[k] << "," << static_cast<int>(figures.validation[k]);
    for (const Series& series : figures.series) {
      out << ",";
      if (k < series.values.size()) {
        out << series.values[k];
      }
    }
    out << "\n";
  }
  if (!out.flush()) {
    throw InputError(file, 0, "", "cannot be written");
  }
}

}  // namespace m100::lab::identify
