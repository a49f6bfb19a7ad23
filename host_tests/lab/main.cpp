// SPDX-License-Identifier: BSD-3-Clause
// m100-lab: the PC's program for the aircraft. Each subcommand is in its own folder (subcommands.h).
#include "firmware/companion/command_line.h"
#include "firmware/companion/version.h"
#include "host_tests/lab/interruption.h"
#include "host_tests/lab/subcommands.h"

namespace {

using m100::companion::Example;

constexpr Example kExamples[]{
    {"campaign", "m100-lab campaign wind_8.toml late_75ms.toml --flights 5 --tasks hover,step_3m --json campaign.json"},
    {"convert", "m100-lab convert flight.ulg --columns columns.toml --out flight.csv --map flight_columns.toml"},
    {"course", "m100-lab course ways.txt table.csv --flight flight.toml --out pictures --json courses.json"},
    {"demo", "m100-lab demo --out demonstration"},
    {"excite", "m100-lab excite --axis roll,pitch --duration 40 --fence 4 --out sticks.csv --json forecast.json"},
    {"flight", "m100-lab flight course.ulg corrected.ulg --out flight.html"},
    {"frames decode", "m100-lab frames decode capture.bin --key-file key"},
    {"frames encode", "m100-lab frames encode frames.jsonl --key-file key"},
    {"experiments", "m100-lab experiments --only hover --seeds 3 --json experiments.json --report report"},
    {"loop", "m100-lab loop --plant plant.toml --out found.toml --json loop.json --report report"},
    {"identify",
     "m100-lab identify --log flight.csv --columns columns.toml --axis roll --declare second_order "
     "--train 12:38 --validate 38:54 --vehicle vehicle.toml --json roll.json"},
    {"paper", "m100-lab paper --pitch-roll ExperimentPitchRoll.mat --height ExperimentHeight.mat"},
    {"autopilot",
     "m100-lab autopilot --pty /tmp/autopilot --pose-pty /tmp/pose --script script.txt --events events.jsonl"},
    {"inject",
     "m100-lab inject --log flight.csv --columns columns.toml --axis roll --train 12:38 --effect dead_zone=20 "
     "--out with.csv --map with.toml"},
    {"logs", "m100-lab logs --log flight.ulg --propose columns.toml"},
    {"report", "m100-lab report report/roll.html report/experiments.html --out whole.html --title \"One flight\""},
    {"gains", "m100-lab gains --vehicle vehicle.toml --table vehicle.gains --json margins.json"},
    {"mpc solve", "m100-lab mpc solve instances.jsonl --scalar float"},
    {"bridge", "m100-lab bridge --listen udp:9763 --to 192.168.1.20:14560 --mavlink-key mavlink.key"},
    {"reference", "m100-lab reference vehicle_keys"},
    {"evening", "m100-lab evening my_m100 --port /dev/ttyUSB0 --pose-port /dev/ttyUSB1"},
};

}  // namespace

// Nothing outside of run() depends on the command line, so only a lack of memory can throw there.
int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): see above
  m100::lab::explain_interruption("\nm100-lab: stopped before the end: the same command begins again\n");
  m100::companion::CommandLine lab{
      "m100-lab: identify a Matrice 100 from its logs, make its gain tables, fly it in simulation"};
  lab.require_subcommand();
  lab.set_version(m100::companion::version_text("m100-lab"));
  lab.show_defaults();
  lab.footer("Exit codes: 0 done, 1 the answer is no, 2 wrong use or bad input (one line on stderr).");
  m100::lab::add_campaign(lab);
  m100::lab::add_convert(lab);
  m100::lab::add_course(lab);
  m100::lab::add_demo(lab);
  m100::lab::add_excite(lab);
  m100::lab::add_flight(lab);
  m100::lab::add_frames(lab);
  m100::lab::add_experiments(lab);
  m100::lab::add_loop(lab);
  m100::lab::add_identify(lab);
  m100::lab::add_paper(lab);
  m100::lab::add_autopilot(lab);
  m100::lab::add_inject(lab);
  m100::lab::add_logs(lab);
  m100::lab::add_report(lab);
  m100::lab::add_gains(lab);
  m100::lab::add_mpc(lab);
  m100::lab::add_reference(lab);
  m100::lab::add_evening(lab);
  m100::lab::add_bridge(lab);
  return lab.run("m100-lab", kExamples, {argv, static_cast<std::size_t>(argc)});
}
