// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace m100::lab {

/// A name in files of older versions, and today's name for it. Readers accept both; only today's is written.
struct Alias {
  std::string_view now;
  std::string_view before;
};

inline constexpr std::array kAliases{
    Alias{"failsafe", "ladder"},                         // result of `fly`, and why an excitation was aborted
    Alias{"ground_station", "room"},                     // result of `fly`
    Alias{"trim_counts", "balance_counts"},              // numbers of an evening
    Alias{"fallback_law", "calm_law"},                   // numbers of an evening
    Alias{"oscillation_deg", "swing_deg"},               // numbers of an evening
    Alias{"limit_cycle_detected_s", "swing_noticed_s"},  // campaign's flights
};

/// Today's form of a name. Of a name with a dot ("calm_law.course") pass only the part before the first dot.
inline std::string_view alias_of(std::string_view part) {
  for (const Alias& alias : kAliases) {
    if (part == alias.before) {
      return alias.now;
    }
  }
  return part;
}

/// A document of any version with every key, inner ones too, in today's form. Json is Json or Json.
template <typename Json>
Json with_current_names(const Json& read) {
  if (read.is_array()) {
    Json out = Json::array();
    for (const Json& item : read) {
      out.push_back(with_current_names(item));
    }
    return out;
  }
  if (!read.is_object()) {
    return read;
  }
  Json out = Json::object();
  for (const auto& [key, value] : read.items()) {
    const std::size_t dot = key.find('.');
    const std::string_view head = std::string_view(key).substr(0, dot);
    const std::string name = std::string(alias_of(head)) + (dot == std::string::npos ? "" : key.substr(dot));
    out[name] = with_current_names(value);
  }
  return out;
}

}  // namespace m100::lab
