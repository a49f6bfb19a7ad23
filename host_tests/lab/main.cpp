// SPDX-License-Identifier: BSD-3-Clause
// m100-lab: everything a PC does for the aircraft. One file per subcommand.
#include <CLI/CLI.hpp>
#include <iostream>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"

int main(int argc, char** argv) {
  CLI::App lab{"m100-lab: identify a Matrice 100 from its logs, make its gain tables, fly it in simulation"};
  lab.require_subcommand(1);
  lab.option_defaults()->always_capture_default();  // --help of every subcommand shows them
  lab.footer("Exit codes: 0 done, 1 the answer is no, 2 wrong use or bad input (one line on stderr).");
  m100::lab::add_campaign(lab);
  m100::lab::add_convert(lab);
  m100::lab::add_excite(lab);
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
  if (argc > 1 && argv[1][0] != '-' &&
      lab.get_subcommands([&](const CLI::App* known) { return known->get_name() == argv[1]; }).empty()) {
    std::cerr << "m100-lab: no subcommand '" << m100::lab::printable(argv[1], 60) << "'; --help lists them\n";
    return m100::lab::kBadInput;
  }
  try {
    lab.parse(argc, argv);
  } catch (const CLI::RuntimeError& stop) {
    return stop.get_exit_code();
  } catch (const CLI::Success& help) {
    return lab.exit(help);
  } catch (const CLI::ParseError& wrong) {
    std::cerr << "m100-lab: " << m100::lab::printable(wrong.what()) << "\n";
    return m100::lab::kBadInput;
  } catch (const std::exception& wrong) {
    std::cerr << "m100-lab: " << m100::lab::printable(wrong.what()) << "\n";
    return m100::lab::kBadInput;
  }
  return m100::lab::kDone;
}
