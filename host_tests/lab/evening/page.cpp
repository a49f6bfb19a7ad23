// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/page.h"

#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/evening/taken_over.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::evening {
namespace {

constexpr double kNoticed_percent = 5.0;  ///< a smaller change of the error is none

using Rows = std::vector<std::vector<std::string>>;

/// One error before and after the correction.
struct Compared {
  std::string words;
  double before = 0.0;
  double after = 0.0;
  bool is_worse() const { return after > (1.0 + kNoticed_percent / 100.0) * before; }
};

/// Every error that both flights of the course gave, by channel.
std::vector<Compared> compared(const Folder& folder) {
  std::vector<std::array<std::string, 3>> names;
  for (const auto& [key, words] :
       {std::pair{"pose_m", "distance from the course [m]"}, std::pair{"horizontal_m", "of it along x and y [m]"},
        std::pair{"x_m", "along x [m]"}, std::pair{"y_m", "along y [m]"}, std::pair{"height_m", "in height [m]"},
        std::pair{"heading_deg", "heading [degrees]"}}) {
    names.push_back({words, std::string(key) + ".course", std::string(key) + ".corrected"});
  }
  for (const Channel& channel : kChannels) {
    const std::string name = std::string("ahead.") + channel.name;
    names.push_back({std::string("predicted 1 s ahead: ") + channel.words, name + ".before", name + ".after"});
  }
  std::vector<Compared> out;
  for (const auto& [words, before, after] : names) {
    if (folder.numbers().contains(before) && folder.numbers().contains(after)) {
      out.push_back({words, folder.numbers().at(before), folder.numbers().at(after)});
    }
  }
  return out;
}

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
  Rows rows{{"root mean square", "before", "after"}};
  for (const Compared& one : compared(folder)) {
    if (one.is_worse()) {
      worse.insert({rows.size(), 2});
    }
    rows.push_back({one.words, plot::number(one.before), plot::number(one.after)});
  }
  page.table(rows, worse);
  page.paragraph(
      "The distances are those of the two flights of the course. What is predicted 1 s ahead is the first of them, "
      "which "
      "no fit has seen, by the first vehicle file and by the corrected one.");
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
  for (const auto& [name, words] : {std::pair{"climb", "Climb speed"}, std::pair{"yaw_rate", "Yaw rate"}}) {
    const auto taken = folder.numbers().find(std::string("found.") + name);
    if (taken != folder.numbers().end()) {
      page.paragraph(std::string(words) +
                     (taken->second > 0.0
                          ? " was identified from the flight that moved throttle and yaw, and flew in the "
                            "corrected flight."
                          : " stays as the first vehicle file has it: what the flight that moved throttle "
                            "and yaw showed predicts that flight no better."));
    }
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
    rows.push_back({name, made.made_by.empty() ? "shipped, or a person" : made.made_by, from.empty() ? "-" : from,
                    "h:" + made.sha256.substr(0, 12)});
  }
  page.table(rows);
}

}  // namespace

std::string before_and_after(const Folder& folder) {
  std::string out;
  for (const Compared& one : compared(folder)) {
    char line[120];
    std::snprintf(line, sizeof line, "  %-46s %8.4f %8.4f%s\n", one.words.c_str(), one.before, one.after,
                  one.is_worse() ? "  worse" : "");
    out += line;
  }
  return out;
}

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
