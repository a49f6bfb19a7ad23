// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ref/minimum_snap.h"

#include "firmware/core/assert.h"
#include "firmware/ref/polynomial.h"

namespace m100::ref {
namespace {

using Form = std::array<std::array<double, 8>, 8>;
using Block = std::array<std::array<double, 3>, 3>;
using Right = std::array<std::array<double, kDimensions>, 3>;

/// W: the quadratic form that gives the integral of the squared snap over normalised time from the end states
/// [p0 v0 a0 j0 p1 v1 a1 j1].
Form snap_form() {
  constexpr std::array<double, 4> kFactor{24.0, 120.0, 360.0, 840.0};  // of c_4 .. c_7 in the fourth derivative
  std::array<std::array<double, 4>, 8> high{};
  for (std::size_t i = 0; i < 8; ++i) {
    EndStates unit;
    (i < 4 ? unit.start : unit.end)[i % 4] = 1.0;
    const Polynomial<double> p = through(unit);
    for (std::size_t k = 0; k < 4; ++k) {
      high[i][k] = kFactor[k] * p.c[4 + k];
    }
  }
  Form w{};
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) {
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
          w[i][j] += high[i][a] * high[j][b] / static_cast<double>(a + b + 1);
        }
      }
    }
  }
  return w;
}

/// The quadratic form in the end states with derivatives by time, not by normalised time, of a piece of this duration.
Form timed(const Form& w, double duration_s) {
  std::array<double, 4> power{};
  power[0] = 1.0;
  for (std::size_t k = 1; k < 4; ++k) {
    power[k] = power[k - 1] * duration_s;
  }
  const double p3 = power[3];
  const double all = 1.0 / (p3 * p3 * duration_s);
  Form out{};
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) {
      out[i][j] = w[i][j] * power[i % 4] * power[j % 4] * all;
    }
  }
  return out;
}

template <std::size_t kColumns>
using Rows = std::array<std::array<double, kColumns>, 3>;

/// row -= factor other
template <std::size_t kColumns>
void subtract(std::array<double, kColumns>& row, double factor, const std::array<double, kColumns>& other) {
  for (std::size_t c = 0; c < kColumns; ++c) {
    row[c] -= factor * other[c];
  }
}

/// into -= by with
template <std::size_t kColumns>
void subtract_product(Rows<kColumns>& into, const Block& by, const Rows<kColumns>& with) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      subtract(into[i], by[i][k], with[k]);
    }
  }
}

/// Gaussian elimination without pivoting (a is positive definite): upper and right become a^-1 upper and a^-1 right.
void solve(Block a, Block& upper, Right& right) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t r = 0; r < 3; ++r) {
      if (r != i) {
        const double factor = a[r][i] / a[i][i];
        subtract(a[r], factor, a[i]);
        subtract(upper[r], factor, upper[i]);
        subtract(right[r], factor, right[i]);
      }
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (double& entry : upper[i]) {
      entry /= a[i][i];
    }
    for (double& entry : right[i]) {
      entry /= a[i][i];
    }
  }
}

/// The rows of the block tridiagonal system that belong to one inner node.
struct NodeRows {
  Block lower{};
  Block diagonal{};
  Block upper{};
  Right right{};
};

/// The equations of one inner node: the squared snap has no gradient in its velocity, acceleration and jerk.
NodeRows rows_of(const Form& before, const Form& after, const Node& last, const Node& node, const Node& next) {
  NodeRows out;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      out.diagonal[i][j] = before[5 + i][5 + j] + after[1 + i][1 + j];
      out.lower[i][j] = before[5 + i][1 + j];
      out.upper[i][j] = after[1 + i][5 + j];
    }
    for (std::size_t d = 0; d < kDimensions; ++d) {
      out.right[i][d] = -(before[5 + i][0] * last.position[d] + before[5 + i][4] * node.position[d] +
                          after[1 + i][0] * node.position[d] + after[1 + i][4] * next.position[d]);
    }
  }
  return out;
}

}  // namespace

void minimise_snap(std::span<Node> nodes, std::span<const double> durations_s) {
  M100_ASSERT(nodes.size() >= 2 && nodes.size() <= kMaxNodes && durations_s.size() + 1 == nodes.size());
  for (const double duration_s : durations_s) {
    M100_ASSERT(duration_s > 0.0);
  }
  const Form w = snap_form();
  std::array<Block, kMaxNodes> upper{};
  std::array<Right, kMaxNodes> right{};
  const std::size_t last = nodes.size() - 1;
  for (std::size_t n = 1; n < last; ++n) {
    NodeRows rows =
        rows_of(timed(w, durations_s[n - 1]), timed(w, durations_s[n]), nodes[n - 1], nodes[n], nodes[n + 1]);
    if (n > 1) {  // eliminate the coupling to the previous node
      subtract_product(rows.diagonal, rows.lower, upper[n - 1]);
      subtract_product(rows.right, rows.lower, right[n - 1]);
    }
    solve(rows.diagonal, rows.upper, rows.right);
    upper[n] = rows.upper;
    right[n] = rows.right;
  }
  for (std::size_t n = last; n-- > 1;) {
    if (n + 1 < last) {
      subtract_product(right[n], upper[n], right[n + 1]);
    }
    nodes[n].velocity = right[n][0];
    nodes[n].acceleration = right[n][1];
    nodes[n].jerk = right[n][2];
  }
  for (Node* end : {&nodes[0], &nodes[last]}) {
    end->velocity = {};
    end->acceleration = {};
    end->jerk = {};
  }
}

}  // namespace m100::ref
