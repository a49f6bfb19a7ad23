// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace CLI {
class App;
}  // namespace CLI

namespace m100::lab {

/// Exit codes of m100 and m100-lab (documented in --help).
enum ExitCode : int { kDone = 0, kAnswerIsNo = 1, kBadInput = 2 };

// Each function adds one subcommand to `lab`. The subcommand's callback throws InputError for bad input and
// CLI::RuntimeError(kAnswerIsNo) when the answer is no.
void add_campaign(CLI::App& lab);
void add_convert(CLI::App& lab);
void add_course(CLI::App& lab);
void add_experiments(CLI::App& lab);
void add_loop(CLI::App& lab);
void add_flight(CLI::App& lab);
void add_excite(CLI::App& lab);
void add_demo(CLI::App& lab);
void add_frames(CLI::App& lab);
void add_identify(CLI::App& lab);
void add_paper(CLI::App& lab);
void add_autopilot(CLI::App& lab);
void add_inject(CLI::App& lab);
void add_logs(CLI::App& lab);
void add_report(CLI::App& lab);
void add_reference(CLI::App& lab);
void add_evening(CLI::App& lab);
void add_bridge(CLI::App& lab);

void add_gains(CLI::App& lab);
void add_mpc(CLI::App& lab);

}  // namespace m100::lab
