// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace m100::companion {

/// How many letters must be inserted, left out, changed, or exchanged with their neighbour to turn one word into the
/// other (optimal string alignment). Only the first 64 bytes count: suggestions need not be exact beyond that.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  constexpr std::size_t kComparedBytes = 64;
  using Row = std::array<std::size_t, kComparedBytes + 1>;
  a = a.substr(0, kComparedBytes);
  b = b.substr(0, kComparedBytes);
  Row before_last{}, last{}, row{};
  for (std::size_t j = 0; j <= b.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last = last;
    last = row;
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      }
    }
  }
  return row[b.size()];
}

/// The end of a message about an unknown word: "; did you mean `damping_ratio`?". Empty if no known word is near
/// enough, or if the word itself is known. @param known rows of which `name` gives the words.
template <typename Rows, typename Name = std::identity>
std::string did_you_mean(std::string_view word, const Rows& known, Name name = {}) {
  std::string_view nearest;
  std::size_t best = word.size();
  for (const auto& row : known) {
    const std::string_view candidate = std::invoke(name, row);
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best && distance < candidate.size() && distance <= std::max<std::size_t>(1, candidate.size() / 3)) {
      nearest = candidate;
      best = distance;
    }
  }
  return nearest.empty() || best == 0 ? "" : "; did you mean `" + std::string(nearest) + "`?";
}

/// The end of a message about an unknown section: the kind of file it belongs to, or the section that may be meant.
template <typename Rows>
std::string section_meant(std::string_view section, const Rows& known) {
  struct Owner {
    std::string_view section;
    std::string_view kind;
  };
  constexpr std::array kOwners{
      Owner{"fence", "flight file (--flight)"},      Owner{"wind", "flight file (--flight)"},
      Owner{"limits", "flight file (--flight)"},     Owner{"signals", "column map (--columns)"},
      Owner{"mpc", "vehicle file (--vehicle)"},      Owner{"estimator", "vehicle file (--vehicle)"},
      Owner{"altitude", "vehicle file (--vehicle)"}, Owner{"translation", "vehicle file (--vehicle)"},
      Owner{"air", "plant file (--plant)"},          Owner{"payload", "plant file (--plant)"},
      Owner{"sensors", "plant file (--plant)"},      Owner{"battery", "flight file (--flight) or plant file (--plant)"},
      Owner{"extra", "column map (--columns)"}};
  for (const Owner& owner : kOwners) {
    if (owner.section == section) {
      return "; this looks like a " + std::string(owner.kind);
    }
  }
  return did_you_mean(section, known);
}

}  // namespace m100::companion
