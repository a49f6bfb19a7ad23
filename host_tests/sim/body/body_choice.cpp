// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/body_choice.h"

#include <optional>
#include <sstream>

#include "host_tests/sim/body/take_off.h"

namespace m100::sim {
namespace {

constexpr std::string_view kScheme = "json:";
constexpr std::string_view kPort = "{port}";

std::string replaced(std::string text, std::string_view word, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += by.size()) {
    text.replace(at, word.size(), by);
  }
  return text;
}

/// HOST and PORT of json:HOST:PORT; nothing: the words mean something else.
std::optional<PhysicsAddress> address_of(const std::string& body) {
  const std::size_t colon = body.rfind(':');
  if (!body.starts_with(kScheme) || colon <= kScheme.size()) {
    return std::nullopt;
  }
  const std::string digits = body.substr(colon + 1);
  if (digits.empty() || digits.size() > 5 || digits.find_first_not_of("0123456789") != std::string::npos) {
    return std::nullopt;
  }
  const unsigned long port = std::stoul(digits);
  if (port < 1 || port > 65535) {
    return std::nullopt;
  }
  return PhysicsAddress{.host = body.substr(kScheme.size(), colon - kScheme.size()),
                        .port = static_cast<std::uint16_t>(port)};
}

}  // namespace

void BodyChoice::check() const {
  if (body != "identified" && !address_of(body)) {
    throw PhysicsError("--body: '" + body + "': must be identified or json:HOST:PORT");
  }
  if (!command.empty() && body != "identified") {
    throw PhysicsError("--body-command: starts its own physics programs; leave --body out");
  }
  if (!command.empty() && command.find(kPort) == std::string::npos) {
    throw PhysicsError("--body-command: has no {port}, so the physics program cannot know where to listen");
  }
}

PhysicsAddress BodyJob::address(const Plant& plant, std::uint64_t seed) {
  if (choice_.command.empty()) {
    return *address_of(choice_.body);
  }
  std::ostringstream wind;
  wind << plant.air.wind_m_s.x() << ',' << 0.0 - plant.air.wind_m_s.y() << ',' << 0.0 - plant.air.wind_m_s.z();
  const std::string wanted = replaced(replaced(choice_.command, "{seed}", std::to_string(seed)), "{wind}", wind.str());
  if (program_ == nullptr || started_for_ != wanted) {
    program_.reset();
    port_ = free_port();
    program_ = std::make_unique<PhysicsProgram>(replaced(wanted, kPort, std::to_string(port_)));
    started_for_ = wanted;
  }
  return {.host = "127.0.0.1", .port = port_, .program = program_.get()};
}

std::unique_ptr<Body> BodyJob::body(const Plant& plant, std::uint64_t seed) {
  return std::make_unique<Body>(plant, seed, address(plant, seed));
}

std::unique_ptr<Body> BodyJob::flying_body(const Plant& plant, std::uint64_t seed,
                                           const core::Vector<double, 3>& place_w_m) {
  std::unique_ptr<Body> out = body(plant, seed);
  take_off(*out, place_w_m);
  return out;
}

}  // namespace m100::sim
