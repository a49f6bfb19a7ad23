// SPDX-License-Identifier: BSD-3-Clause
// The subcommand `identify` alone: host_tests/main_job has its result before the rest of m100-lab is built.
#include "firmware/companion/command_line.h"
#include "host_tests/lab/subcommands.h"

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): as in m100-lab
  m100::companion::CommandLine lab{"m100-identify: identify a Matrice 100 from its logs"};
  lab.require_subcommand();
  m100::lab::add_identify(lab);
  return lab.run("m100-identify", {}, {argv, static_cast<std::size_t>(argc)});
}
