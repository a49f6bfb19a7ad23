// SPDX-License-Identifier: BSD-3-Clause
// m100: the program on the companion board. The subcommands are in the folders beside this file.
#include "firmware/companion/command_line.h"
#include "firmware/companion/subcommands.h"
#include "firmware/companion/version.h"

namespace {

using m100::companion::Example;

constexpr std::string_view kFlights[]{"fly", "handshake", "record"};
constexpr Example kExamples[]{
    {"fly",
     "m100 fly --port /dev/ttyUSB0 --pose-port /dev/ttyUSB1 --vehicle vehicle.toml --gains vehicle.gains "
     "--flight flight.toml --course square.course --log flight.ulg --json flight.json"},
    {"handshake", "m100 handshake --port /dev/ttyUSB0 --hold 5 --json handshake.json"},
    {"probe", "m100 probe --port /dev/ttyUSB0 --json probe.json"},
    {"record", "m100 record --port /dev/ttyUSB0 --pose-port /dev/ttyUSB1 --log hand.ulg --hold 60"},
    {"doctor", "m100 doctor --port /dev/ttyUSB0 --folder logs --json doctor.json"},
    {"check", "m100 check --vehicle vehicle.toml --gains vehicle.gains --flight flight.toml --json check.json"},
    {"replay", "m100 replay flight.ulg --scalar float --json replay.json"},
};

}  // namespace

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): out of memory, which ends it as well
  m100::companion::CommandLine m100{"m100: fly a Matrice 100 from a companion board"};
  m100.require_subcommand();
  m100.set_version(m100::companion::version_text("m100"));
  m100.show_defaults();
  m100.footer("Exit codes: 0 done, 1 the answer is no, 2 wrong use or bad input (one line on stderr).");
  m100::companion::add_fly(m100);
  m100::companion::add_handshake(m100);
  m100::companion::add_probe(m100);
  m100::companion::add_record(m100);
  m100::companion::add_doctor(m100);
  m100::companion::add_check(m100);
  m100::companion::add_replay(m100);
  return m100.run("m100", kExamples, {argv, static_cast<std::size_t>(argc)}, kFlights);
}
