// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace m100::lab::excite {

/// One movement: its shape over its own time, between -1 and 1.
struct Piece {
  double length_s = 0.0;
  std::function<double(double)> shape;  ///< as a function of the time since its start [s]
  /// Times [s] at which the stick passes neutral and the movement may be split, with a return to the start between the
  /// parts. Empty for a doublet and a 3211, which are flown whole.
  std::vector<double> breaks_s;
};

/// The movements of a kind, in their order. @throws std::invalid_argument: no such kind.
std::vector<Piece> pieces(const std::string& kind);

}  // namespace m100::lab::excite
