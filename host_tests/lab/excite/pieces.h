// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace m100::lab::excite {

/// One movement: shape over its own time, between -1 and 1.
struct Piece {
  double length_s = 0.0;
  std::function<double(double)> shape;  ///< of the time since its begin [s]
  /// Where the stick passes its middle: there it may be flown in parts, with a return to the place between them. A
  /// doublet and a 3211 have none: they bring the aircraft back by themselves.
  std::vector<double> breaks_s;
};

/// The movements of a kind, in their order. @throws std::invalid_argument: no such kind.
std::vector<Piece> pieces(const std::string& kind);

}  // namespace m100::lab::excite
