// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/events.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace m100::authority {

Events::~Events() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

bool Events::poll() {
  if (descriptor_ < 0) {
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) {
      return false;
    }
  }
  std::array<char, 8192> buffer;
  bool more = false;
  for (ssize_t count = 0; (count = ::read(descriptor_, buffer.data(), buffer.size())) > 0;) {
    rest_.append(buffer.data(), static_cast<std::size_t>(count));
    more = true;
  }
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1) {
    take_line(std::string_view(rest_).substr(begin, end - begin));
  }
  rest_.erase(0, begin);
  return more;
}

void Events::take_line(std::string_view line) {
  const Json read = Json::parse(line);
  now_s_ = read.at("t_s").get<double>();
  const std::string what = read.at("what").get<std::string>();
  if (what == "summary") {
    summary_ = read;
    return;
  }
  if (what == "truth") {
    truths_.push_back(
        {now_s_, read.at("x_m").get<double>(), read.at("y_m").get<double>(), read.at("z_m").get<double>()});
    return;
  }
  const std::string name = read.at("name").get<std::string>();
  if (name == "transmitter_has_control" || name == "transmitter_lost_control") {
    changes_.push_back({now_s_, name == "transmitter_has_control"});
  }
  events_.push_back({now_s_, what, name, read.at("value").get<double>()});
}

double Events::first_s(std::string_view what, std::string_view name) const {
  const auto found = std::find_if(events_.begin(), events_.end(),
                                  [&](const Event& event) { return event.what == what && event.name == name; });
  return found == events_.end() ? kNever_s : found->t_s;
}

bool Events::client_flew_at(double t_s) const {
  bool his = true;
  for (const Change& change : changes_) {
    his = change.t_s <= t_s ? change.to_transmitter : his;
  }
  return !his;
}

double Events::transmitter_for_good_s() const {
  if (changes_.empty()) {
    return 0.0;
  }
  return changes_.back().to_transmitter ? changes_.back().t_s : kNever_s;
}

double Events::transmitter_from_s(double t_s) const {
  if (!client_flew_at(t_s)) {
    return t_s;
  }
  for (const Change& change : changes_) {
    if (change.t_s >= t_s && change.to_transmitter) {
      return change.t_s;
    }
  }
  return kNever_s;
}

std::size_t Events::commands_taken_before(double t_s) const {
  return static_cast<std::size_t>(std::count_if(events_.begin(), events_.end(), [&](const Event& event) {
    return event.t_s < t_s && event.what == "received" && (event.name == "vrc_data" || event.name == "movement");
  }));
}

double Events::farthest_from_m(double t_s) const {
  const auto from = std::find_if(truths_.begin(), truths_.end(), [&](const Truth& truth) { return truth.t_s >= t_s; });
  double farthest_m = 0.0;
  for (auto truth = from; truth != truths_.end(); ++truth) {
    farthest_m = std::max(farthest_m, std::hypot(truth->x_m - from->x_m, truth->y_m - from->y_m));
  }
  return farthest_m;
}

}  // namespace m100::authority
