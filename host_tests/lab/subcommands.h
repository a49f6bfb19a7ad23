// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/subcommands.h"

namespace m100::lab {

// Each function adds one subcommand to `lab`. The subcommand's callback throws InputError for bad input and
// companion::AnswerIsNo when the answer is no.
void add_campaign(companion::CommandLine& lab);
void add_convert(companion::CommandLine& lab);
void add_course(companion::CommandLine& lab);
void add_experiments(companion::CommandLine& lab);
void add_loop(companion::CommandLine& lab);
void add_flight(companion::CommandLine& lab);
void add_excite(companion::CommandLine& lab);
void add_demo(companion::CommandLine& lab);
void add_frames(companion::CommandLine& lab);
void add_identify(companion::CommandLine& lab);
void add_paper(companion::CommandLine& lab);
void add_autopilot(companion::CommandLine& lab);
void add_inject(companion::CommandLine& lab);
void add_logs(companion::CommandLine& lab);
void add_report(companion::CommandLine& lab);
void add_reference(companion::CommandLine& lab);
void add_evening(companion::CommandLine& lab);
void add_bridge(companion::CommandLine& lab);
void add_gains(companion::CommandLine& lab);
void add_mpc(companion::CommandLine& lab);

}  // namespace m100::lab
