// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "host_tests/sim/body/body.h"

namespace m100::sim {

/// Which aircraft flies: the identified response, a body of a physics program that runs, or one that we start.
struct BodyChoice {
  std::string body = "identified";  ///< or json:HOST:PORT
  /// A shell command; {port}, {seed} and {wind} (north,east,down in m/s, from [air] wind_m_s) are replaced. Empty:
  /// none.
  std::string command;

  bool is_identified() const { return command.empty() && body == "identified"; }
  bool passes_wind() const { return command.find("{wind}") != std::string::npos; }
  /// @throws PhysicsError what is wrong with the words.
  void check() const;
};

/// The bodies of one job, one after the other. A program that we started flies again as long as its command stays the
/// same; each body resets it by its frame count.
class BodyJob {
 public:
  explicit BodyJob(const BodyChoice& choice) : choice_(choice) {}
  /// A body on the ground.
  std::unique_ptr<Body> body(const Plant& plant, std::uint64_t seed);
  /// A body in the air at the place where a flight begins.
  std::unique_ptr<Body> flying_body(const Plant& plant, std::uint64_t seed, const core::Vector<double, 3>& place_w_m);

 private:
  PhysicsAddress address(const Plant& plant, std::uint64_t seed);

  BodyChoice choice_;
  std::string started_for_;  ///< the command before {port} was replaced
  std::unique_ptr<PhysicsProgram> program_;
  std::uint16_t port_ = 0;
};

}  // namespace m100::sim
