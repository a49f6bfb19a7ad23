// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/sensor_faults/command_faults.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace m100::scenario {
namespace {

constexpr std::size_t kMaxCommandFaults = 6;

double drawn_value(CommandFaultKind kind, sim::Random& random) {
  switch (kind) {
    case CommandFaultKind::kLoseAcks:
    case CommandFaultKind::kDoubleAcks:
      return static_cast<double>(1 + random.next() % 5);
    case CommandFaultKind::kDelayAcks:
    case CommandFaultKind::kReportsOurs:
    case CommandFaultKind::kReportsPilot:
    case CommandFaultKind::kReportsMode:
      return 0.02 * std::pow(200.0, random.uniform());  // seconds
    default:
      return 0.0;
  }
}

CommandFault drawn_command_fault(bool operators, double within_s, sim::Random& random) {
  const std::size_t first = operators ? 0 : kOperatorWords;
  const std::size_t count = operators ? kOperatorWords : kCommandFaultNames.size() - kOperatorWords;
  CommandFault command_fault;
  command_fault.kind = static_cast<CommandFaultKind>(first + random.next() % count);
  command_fault.at_s = within_s * random.uniform();
  command_fault.value = drawn_value(command_fault.kind, random);
  return command_fault;
}

}  // namespace

std::string to_text(const CommandFaults& command_faults) {
  std::ostringstream out;
  out.precision(4);
  for (std::size_t i = 0; i < command_faults.size(); ++i) {
    const CommandFault& one = command_faults[i];
    out << (i > 0 ? "; " : "") << kCommandFaultNames[static_cast<std::size_t>(one.kind)] << " " << one.at_s << " "
        << one.value;
  }
  return out.str();
}

CommandFaults command_faults_of(const std::string& text) {
  CommandFaults command_faults;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ';');) {
    std::istringstream words(part);
    std::string kind;
    CommandFault one;
    words >> kind >> one.at_s >> one.value;
    const auto* const found = std::find(kCommandFaultNames.begin(), kCommandFaultNames.end(), kind);
    if (words.fail() || found == kCommandFaultNames.end()) {
      throw std::invalid_argument("unknown happening: " + part);
    }
    one.kind = static_cast<CommandFaultKind>(found - kCommandFaultNames.begin());
    command_faults.push_back(one);
  }
  return command_faults;
}

CommandFaults drawn_command_faults(bool operators, double within_s, sim::Random& random) {
  CommandFaults command_faults;
  for (std::size_t count = 1 + random.next() % kMaxCommandFaults; count > 0; --count) {
    command_faults.push_back(drawn_command_fault(operators, within_s, random));
  }
  return command_faults;
}

CommandFaults neighbour_of(const CommandFaults& command_faults, bool operators, double within_s, sim::Random& random) {
  CommandFaults next = command_faults;
  CommandFault& one = next[random.next() % next.size()];
  const double dice = random.uniform();
  if (dice < 0.2 && next.size() < kMaxCommandFaults) {
    next.push_back(drawn_command_fault(operators, within_s, random));
  } else if (dice < 0.4 && next.size() > 1) {
    one = next.back();
    next.pop_back();
  } else if (dice < 0.7) {
    one.at_s = std::clamp(one.at_s + random.normal(), 0.0, within_s);
  } else {
    one = drawn_command_fault(operators, within_s, random);
  }
  return next;
}

}  // namespace m100::scenario
