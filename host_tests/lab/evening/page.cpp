// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/page.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::evening {
namespace {

constexpr double kNoticed_percent = 5.0;  ///< a smaller change of the error is none

using Rows = std::vector<std::vector<std::string>>;

/// The number of that name; "-" where the evening did not get that far.
std::string number(const Folder& folder, const std::string& name) {
  const auto found = folder.numbers().find(name);
  return found == folder.numbers().end() ? "-" : plot::number(found->second);
}

void flights(const Folder& folder, plot::Page& page) {
  const auto before = folder.numbers().find("pose_m.course");
  const auto after = folder.numbers().find("pose_m.corrected");
  if (before == folder.numbers().end() || after == folder.numbers().end()) {
    page.verdict("The corrected flight was not flown yet.", "warn");
    return;
  }
  const double change = 100.0 * (after->second / before->second - 1.0);
  page.verdict("Distance from the reference on the same course, root mean square: " + plot::number(before->second) +
                   " m before, " + plot::number(after->second) + " m after (" + plot::number(change) + " %).",
               change < -kNoticed_percent  ? "good"
               : change < kNoticed_percent ? "warn"
                                           : "bad");
  plot::Cells worse;
  Rows rows{{"flight, root mean square [m]", "before", "after"}};
  for (const auto& [key, words] :
       {std::pair{"pose_m", "distance from the course"}, std::pair{"horizontal_m", "of it along x and y"},
        std::pair{"height_m", "of it in height"}}) {
    const std::string name = key;
    if (folder.numbers().contains(name + ".course") && folder.numbers().contains(name + ".corrected") &&
        folder.numbers().at(name + ".corrected") >
            (1.0 + kNoticed_percent / 100.0) * folder.numbers().at(name + ".course")) {
      worse.insert({rows.size(), 2});
    }
    rows.push_back({words, number(folder, name + ".course"), number(folder, name + ".corrected")});
  }
  page.table(rows, worse);
  if (folder.numbers().contains(kCalmer)) {
    page.paragraph(
        std::string(
            "The loop swung with the weights of the log that was flown by hand: they were made calmer (the input "
            "weight threefold, ") +
        (folder.numbers().at(kCalmer) > 1.5 ? "twice" : "once") + "), before and after alike.");
  }
  if (folder.numbers().contains(kBalanced)) {
    page.paragraph("The trims of the first vehicle file were taken from the hover, before and after alike.");
  }
}

void found(const Folder& folder, plot::Page& page) {
  page.heading("What was found");
  Rows rows{{"axis", "quantity", "flown by hand", "excited flight"}};
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
  page.paragraph("A delay or trim of 0 was not named: the log shows none beyond what is declared.");
  page.paragraph(
      "Climb and yaw rate are not identified: the evening moves the sticks of roll and pitch only, and throttle and "
      "yaw, "
      "which the law moves by a few counts to hold height and heading, show no model of their axes. What the first "
      "vehicle file says of both stays in force. m100-lab excite --axis climb or yaw_rate forecasts what a flight made "
      "for them would show in this room.");
}

void files(const Folder& folder, plot::Page& page) {
  page.heading("Which file was made from which");
  Rows rows{{"file", "made by", "from", "SHA-256 begins"}};
  for (const auto& [name, made] : folder.files()) {
    std::string from;
    for (const auto& [source, hash] : made.from) {
      from += (from.empty() ? "" : ", ") + source;
    }
    rows.push_back({name, made.made_by.empty() ? "shipped, or a person" : made.made_by, from.empty() ? "-" : from,
                    "h:" + made.sha256.substr(0, 12)});
  }
  page.table(rows);
}

}  // namespace

void write_summary(const Folder& folder, const std::string& version) {
  plot::Page page("One evening: from the first byte to the corrected flight");
  flights(folder, page);
  page.paragraph(
      "Asked: what does the vehicle file that was identified by hand lack in flight, and does its correction fly "
      "better?");
  if (folder.settings().port.starts_with("sim:")) {
    page.paragraph("The aircraft is emulated: every number of a flight on this page is simulated.");
  }
  found(folder, page);
  files(folder, page);
  page.paragraph("m100-lab " + version + ".");
  page.write(folder.file("summary.html"));
}

}  // namespace m100::lab::evening
