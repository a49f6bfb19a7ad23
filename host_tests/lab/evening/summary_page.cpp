// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/summary_page.h"

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tests/lab/evening/corrected_vehicle.h"
#include "host_tests/lab/evening/law_comparison.h"
#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/flight/figures.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::evening {
namespace {

constexpr double kNoticed = 1.05;  ///< of a prediction's error, after over before; smaller growth is ignored

using Rows = std::vector<std::vector<std::string>>;

constexpr std::string_view kAhead = "predicted 1 s ahead: ";

/// One error before and after the correction.
struct Compared {
  std::string words;
  double before = 0.0;
  double after = 0.0;
  std::string verdict{};  ///< of a flown error: FlownErrors; of a prediction: "larger"; empty: none
  bool is_bad() const { return verdict == "worse" || verdict == "larger"; }
};
using Comparison = std::vector<Compared>;

/// The errors that are known before and after the correction: of the flights of the course, and of the predictions.
Comparison compared(const Folder& folder, const FlownErrors& flown) {
  Comparison out;
  const auto add = [&](const std::string& words, const std::string& before, const std::string& after) {
    const bool is_known = folder.numbers().contains(before) && folder.numbers().contains(after);
    if (is_known) {
      out.push_back({words, folder.numbers().at(before), folder.numbers().at(after)});
    }
    return is_known;
  };
  for (const auto& [key, words] :
       {std::pair{"pose_m", "distance from the course [m]"}, std::pair{"horizontal_m", "horizontal distance [m]"},
        std::pair{"x_m", "along x [m]"}, std::pair{"y_m", "along y [m]"}, std::pair{"height_m", "in height [m]"},
        std::pair{"heading_deg", "heading [degrees]"}}) {
    if (add(words, std::string(key) + ".course", std::string(key) + ".corrected") && flown.contains(key)) {
      out.back().verdict = flown.at(key).verdict();
    }
  }
  for (const VehicleAxis& axis : kVehicleAxes) {
    const std::string name = std::string("ahead.") + axis.name;
    if (add(std::string(kAhead) + axis.words, name + ".before", name + ".after")) {
      out.back().verdict = out.back().after > kNoticed * out.back().before ? "larger" : "";
    }
  }
  return out;
}

/// The number of that name; "-" if the evening has not reached it.
std::string number(const Folder& folder, const std::string& name) {
  const auto found = folder.numbers().find(name);
  return found == folder.numbers().end() ? "-" : plot::number(found->second);
}

/// The flights of the course ("before", "after") that oscillated, so that the fallback law took over.
std::vector<std::string> fallback_law_flew(const Folder& folder) {
  std::vector<std::string> out;
  for (const auto& [flight, words] : {std::pair{kBefore, "before"}, std::pair{kAfter, "after"}}) {
    if (folder.number(std::string(kFallbackLaw) + flight) > 0.0) {
      out.emplace_back(words);
    }
  }
  return out;
}

bool is_taken_over(const Folder& folder, const std::string& channel) { return folder.number("found." + channel) > 0.0; }

/// Whether the channel is the climb, and its new model predicts better but was not kept (compare_laws()).
bool is_kept_back(const Folder& folder, const std::string& channel) {
  return channel == "climb" && folder.numbers().contains("kept.corrected_climb") &&
         folder.number("kept.corrected_climb") == 0.0 &&
         folder.number("ahead.climb.after") < folder.number("ahead.climb.before");
}

/// One sentence: the corrections that the excited flight gave to the first vehicle file.
std::string found_in_short(const Folder& folder) {
  std::string out = "found in the excited flight: ";
  for (const std::string axis : {"roll", "pitch"}) {
    const auto change = [&](const std::string& key) {
      return number(folder, key + "." + axis + ".before") + ", now " + number(folder, key + "." + axis + ".after");
    };
    out += axis + ": transport delay [s] " + change("transport_delay_s") + ", trim [counts] " + change("trim_counts") +
           "; ";
  }
  const auto rate = [&](const char* channel) {
    return is_taken_over(folder, channel)  ? "corrected"
           : is_kept_back(folder, channel) ? "found, but not kept, because it flies worse in height"
                                           : "unchanged";
  };
  const bool has_drag = is_taken_over(folder, "translation");
  return out + "climb speed: " + rate("climb") + "; yaw rate: " + rate("yaw_rate") +
         "; drag [1/s]: " + (has_drag ? number(folder, "linear_drag_per_s") : "unchanged") + ".";
}

std::string change(const Compared& one) { return one.before > 0.0 ? plot::percent(one.after / one.before - 1.0) : ""; }

/// One sentence: the errors of the predictions 1 s ahead by both files.
std::string predicted_ahead(const Comparison& all) {
  std::string out;
  for (const Compared& one : all) {
    if (one.words.starts_with(kAhead)) {
      out += (out.empty() ? "error of the predictions 1 s ahead: " : "; ") + one.words.substr(kAhead.size()) + " " +
             plot::number(one.before) + " to " + plot::number(one.after) + " (" + change(one) + ")";
    }
  }
  return out + (out.empty() ? "" : ".");
}

/// One sentence: the errors that became worse, and the parts of the vehicle file that the evening does not correct.
std::string not_reached(const Folder& folder, const Comparison& all) {
  std::string out;
  for (const Compared& one : all) {
    if (one.is_bad()) {
      out += one.words + " became " + one.verdict + " (" + plot::number(one.before) + " to " + plot::number(one.after) +
             "); ";
    }
  }
  return (out.empty() ? "no error became worse; " : out) + (is_taken_over(folder, "translation") ? "" : "drag, ") +
         "wind and load are not identified and stay as in the first vehicle file.";
}

/// What the errors in flight do not show: each law's delay margin. Empty: unknown.
std::string margins(const Folder& folder) {
  const auto margin = [&](const char* law) {
    const double margin_s = folder.number(std::string("delay_margin_s.") + law);
    return margin_s > 0.0 ? plot::number(1e3 * margin_s) + " ms" : "none";
  };
  return folder.numbers().contains("kept.corrected")
             ? " The delay margin on the corrected model was " + margin("first") + ", now " + margin("corrected") + "."
             : "";
}

/// Writes the first screen: question, findings, what they explain and change, what remains, and both flights.
void outcome(const Folder& folder, const FlownErrors& flown, const Comparison& all, plot::Page& page) {
  const std::string data = folder.settings().port.starts_with("sim:") ? " (simulated)" : "";
  const auto pose = flown.find("pose_m");
  const bool is_flown = pose != flown.end();
  page.begin_answer(
      {{"Asked",
        "which effects does a vehicle file miss that was identified from a log flown by hand, and does the corrected "
        "file fly better?"},
       {"Missing in the model", found_in_short(folder)},
       {"What it explains" + data, predicted_ahead(all)},
       {"What it changed in flight" + data,
        is_flown ? "distance from the reference on the same course, root mean square, before -> after: " +
                       describe(pose->second) + ". " + paired_rule() + margins(folder)
                 : "the corrected flight was not flown yet."},
       {"What remains", not_reached(folder, all)}},
      is_flown && all.front().verdict == "better"  ? "good"
      : is_flown && all.front().verdict == "worse" ? "bad"
                                                   : "warn");
  if (is_flown) {
    page.figure(flight::distance_figure({flight::read_series(folder.file(std::string(kBefore) + ".ulg"), nullptr),
                                         flight::read_series(folder.file(std::string(kAfter) + ".ulg"), nullptr)}),
                "Of the poses; dashed: root mean square.");
  }
  page.end_answer();
  page.paragraph(data.empty() ? "The numbers of the flights come from the logs of the board."
                              : "The aircraft is emulated: every number of a flight on this page is simulated.");
}

/// Writes each error before and after, the verdicts, and what else changed between the two flights.
void flights(const Folder& folder, const FlownErrors& flown, const Comparison& all, plot::Page& page) {
  plot::Cells worse;
  Rows rows{{"root mean square", "before", "after", "change"}};
  for (const Compared& one : all) {
    if (one.is_bad()) {
      worse.insert({rows.size(), 2});
    }
    rows.push_back({one.words, plot::number(one.before), plot::number(one.after),
                    change(one) + (one.verdict.empty() ? "" : ", " + one.verdict)});
  }
  page.table(rows, worse);
  page.list(law_verdicts(folder, flown));
  page.paragraph(
      "The distances are those of the flights of the course. The predictions 1 s ahead are of the flight before "
      "the correction, which no fit has used: by the first vehicle file (before) and by the corrected one (after).");
  if (folder.numbers().contains(kWeightIncreases)) {
    page.paragraph(
        std::string("The loop oscillated with the weights that were tuned on the log flown by hand. The input weight "
                    "was therefore tripled ") +
        (folder.numbers().at(kWeightIncreases) > 1.5 ? "twice" : "once") + ", for the flight before.");
  }
  for (const std::string& name : fallback_law_flew(folder)) {
    page.paragraph("The flight " + name +
                   " the correction began to oscillate, and the fallback law took over. This made its error larger, so "
                   "the change is not the effect of the correction alone.");
  }
  if (folder.numbers().contains(kTrimmed)) {
    page.paragraph("The flight before used trims that were taken from the hover.");
  }
}

void found(const Folder& folder, plot::Page& page) {
  page.heading("What was found");
  Rows rows{{"axis", "quantity", "from the log flown by hand", "from the excited flight"}};
  const std::array<std::array<const char*, 2>, 3> quantities{{{"rmse_rad", "error on unseen data [rad]"},
                                                              {"transport_delay_s", "transport delay [s]"},
                                                              {"trim_counts", "trim [counts]"}}};
  for (const std::string axis : {"roll", "pitch"}) {
    for (const auto& [key, words] : quantities) {
      const std::string name = std::string(key) + "." + axis;
      rows.push_back({axis, words, number(folder, name + ".before"), number(folder, name + ".after")});
    }
  }
  page.table(rows);
  page.paragraph(
      "A delay or trim of 0 means that the log shows none. The errors on unseen data belong to two different flights: "
      "they show how good each model is on its own flight, not which model is better.");
  for (const auto& [name, words] : {std::pair{"climb", "Climb speed"}, std::pair{"yaw_rate", "Yaw rate"}}) {
    page.paragraph(std::string(words) +
                   (is_taken_over(folder, name)
                        ? " was identified from the flight that moved throttle and yaw; the corrected flight used it."
                        : " stays as in the first vehicle file: the model identified from the flight that moved "
                          "throttle and yaw " +
                              std::string(is_kept_back(folder, name) ? "predicts better, but flies worse in height."
                                                                     : "does not predict that flight better.")));
  }
}

void files(const Folder& folder, plot::Page& page) {
  page.heading("Which file was made from which");
  Rows rows{{"file", "made by", "from", "SHA-256 begins"}};
  for (const auto& [name, made] : folder.files()) {
    std::string from;
    for (const auto& [source, hash] : made.from) {
      from += (from.empty() ? "" : ", ") + source;
    }
    rows.push_back({name, made.made_by.empty() ? "shipped or by a person" : made.made_by, from.empty() ? "-" : from,
                    "h:" + made.sha256.substr(0, 12)});
  }
  page.table(rows);
}

}  // namespace

std::string before_and_after(const Folder& folder) {
  std::string out;
  const FlownErrors flown = compare_flights(folder);
  for (const Compared& one : compared(folder, flown)) {
    out += printed("  %-63s %8.4f %8.4f%s\n", one.words.c_str(), one.before, one.after,
                   (one.verdict.empty() ? "" : "  " + one.verdict).c_str());
  }
  for (const std::string& name : fallback_law_flew(folder)) {
    out += "  the flight " + name + " the correction began to oscillate, and the fallback law took over\n";
  }
  for (const std::string& verdict : law_verdicts(folder, flown)) {
    out += "  " + verdict + "\n";
  }
  return out;
}

void write_summary(const Folder& folder) {
  plot::Page page("One evening: from the first byte to the corrected flight");
  const FlownErrors flown = compare_flights(folder);
  const Comparison all = compared(folder, flown);
  outcome(folder, flown, all, page);
  flights(folder, flown, all, page);
  found(folder, page);
  files(folder, page);
  page.write(folder.file("summary.html"));
}

}  // namespace m100::lab::evening
