// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/command_line.h"
#include "host_tests/sim/body/body_choice.h"

namespace m100::lab {

/// Adds --body and --body-command.
inline void add_body_options(const companion::Subcommand& command, sim::BodyChoice& body) {
  command.add_option("--body", body.body,
                     "identified: the response that was measured; json:HOST:PORT: a body whose physics another program "
                     "computes (ArduPilot's SIM_JSON), flown by the autopilot's own loops");
  command.add_option("--body-command", body.command,
                     "shell command that starts such a physics program on 127.0.0.1; {port}, {seed} and {wind} "
                     "(north,east,down in m/s, from the plant's air) are replaced");
}

}  // namespace m100::lab
