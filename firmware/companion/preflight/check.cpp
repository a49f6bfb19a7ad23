// SPDX-License-Identifier: BSD-3-Clause
// m100 check: do the vehicle file, the gain table, the flight file, the course and the limits of the program agree?
// Nothing flies.
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/fly/flight_files.h"
#include "firmware/companion/fly/flight_model.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/companion/preflight/model_findings.h"

namespace m100::companion {
namespace {

/// Reads and checks flight file and course as `fly` does, as far as that is possible without a start. @returns the mode
/// that would fly.
Mode check_orders(const FlyOptions& options, std::vector<ConsistencyFinding>& out) {
  const FlightFiles orders(options);
  const Range start_z_m = check_offsets(orders);
  if (orders.flight) {
    out.push_back({"", true, "the flight file has a fence around the start, and every key is in its range"});
    if (const std::string lever = describe_lever_arm(*orders.flight); !lever.empty()) {
      out.push_back({"", true, lever});
    }
  }
  if (!options.course.empty()) {
    std::ostringstream text;
    text << "the course can be flown";
    if (orders.flight) {
      text << ", inside the fence if it starts at a height of " << start_z_m.low << " to " << start_z_m.high << " m";
    }
    out.push_back({"", true, text.str()});
  }
  return orders.mode;
}

Json to_json(const std::vector<ConsistencyFinding>& all, Mode mode, bool agrees) {
  Json list = Json::array();
  for (const ConsistencyFinding& finding : all) {
    list.push_back({{"check", finding.name}, {"holds", finding.holds}, {"what", finding.what}});
  }
  return {{"agrees", agrees}, {"mode", name(mode)}, {"findings", std::move(list)}};
}

void run_check(const FlyOptions& options) {
  check_files(options);
  // This constructor refuses any changed bit, and tables of another vehicle.
  const FlightModel field(options.vehicle, options.gains, Mode::kField);
  std::vector<ConsistencyFinding> all{{"", true, "the gain table is intact and was made from this vehicle file"}};
  const Mode mode = check_orders(options, all);
  const FlightModel flown(options.vehicle, options.gains, mode);
  all.push_back({"", true, "the gain table has the table of mode " + std::string(name(mode))});
  const std::vector<ConsistencyFinding> more = findings(flown);
  all.insert(all.end(), more.begin(), more.end());
  bool agrees = true;
  for (const ConsistencyFinding& finding : all) {
    std::cout << (finding.holds ? "ok    " : "WRONG ") << finding.what;
    std::cout << (finding.holds ? "" : ": fly refuses it without --override " + std::string(finding.name)) << "\n";
    agrees = agrees && finding.holds;
  }
  if (!options.json.empty()) {
    write_json(options.json, to_json(all, mode, agrees));
  }
  if (!agrees) {
    throw AnswerIsNo();
  }
}

}  // namespace

void add_check(CommandLine& m100) {
  const auto [app, options] = m100.add_subcommand<FlyOptions>(
      "check", "check whether vehicle file, gain table, flight file, course and limits agree", run_check);
  app.add_option("--vehicle", options->vehicle, "vehicle file (TOML)").required();
  app.add_option("--gains", options->gains, "gain table file made from it by m100-lab gains --table").required();
  app.add_option("--flight", options->flight, "flight file (TOML), as fly takes it");
  app.add_option("--course", options->course, "course file, as fly takes it");
  app.add_option("--json", options->json, "each finding, and whether all agree, as JSON");
  app.footer(course_help());
}

}  // namespace m100::companion
