// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "host_tests/lab/logs/formats/ros_types.h"
#include "host_tests/lab/logs/no_such_column.h"

namespace m100::lab::logs {

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
}  // namespace

void RosTopic::decode(double start_s) {
  if (decoded_) {
    return;
  }
  decoded_ = true;
  bool named = false;
  std::vector<double> numbers;
  for (const auto& [bytes, received_s] : messages) {
    numbers.clear();
    std::vector<std::string> paths;
    const auto note = [&](const std::string& path, double value) {
      numbers.push_back(value);
      if (!named) {
        paths.push_back(path);
      }
    };
    std::string wrong = unknown.empty() ? type.walk(bytes, !named, note) : unknown;
    if (wrong.empty() && !named) {
      named = true;
      names_ = std::move(paths);
      columns_.assign(names_.size(), std::vector<double>(time_s_.size(), kNone));
    }
    if (wrong.empty() && numbers.size() != columns_.size()) {
      wrong = "has arrays whose lengths differ from the first message's";
    }
    if (!wrong.empty()) {
      error_text_ = error_text_.empty() ? wrong : error_text_;
      numbers.assign(columns_.size(), kNone);
    }
    append(numbers, received_s - start_s, start_s);
  }
}

void RosTopic::append(const std::vector<double>& numbers, double received_s, double start_s) {
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    columns_[k].push_back(numbers[k]);
  }
  const auto stamp = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), "header.stamp") - names_.begin());
  const bool is_stamped = stamp < numbers.size() && numbers[stamp] > 0.0;  // a damaged message has no numbers
  time_s_.push_back(is_stamped ? numbers[stamp] - start_s : received_s);
}

const std::vector<double>* RosTopic::field(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? nullptr : &columns_[static_cast<std::size_t>(found - names_.begin())];
}

std::vector<double> RosTopic::counter() const {
  const std::vector<double>* const numbers = field("header.seq");
  const bool counts = numbers != nullptr && numbers->size() > 1 && numbers->front() != numbers->back();
  return counts ? *numbers : std::vector<double>{};
}

void RosLog::start() {
  double first = std::numeric_limits<double>::infinity();
  for (const auto& [name, topic] : topics_) {
    for (const auto& message : topic.messages) {
      first = std::min(first, message.second);
    }
  }
  if (!std::isfinite(first)) {
    throw InputError(file(), 0, "", "holds no message");
  }
  start_s_ = first;
}

RawColumn RosLog::column(const std::string& name, const std::string& map_key) const {
  const std::size_t dot = name.find('.');
  const auto found = topics_.find(name.substr(0, dot));
  if (found == topics_.end() || dot == std::string::npos) {
    throw NoSuchColumn(file(), 0, name,
                       "no such topic (wanted for " + map_key + "); near: " + nearest_names(names(), name));
  }
  RosTopic& topic = found->second;
  topic.decode(start_s_);
  RawColumn out;
  out.time_s = topic.times();
  out.sequence = topic.counter();
  const std::string field = name.substr(dot + 1);
  const std::vector<double>* const values = field == "time" ? &topic.times() : topic.field(field);
  if (values == nullptr) {
    throw NoSuchColumn(file(), 0, name,
                       topic.names().empty() && !topic.error_text().empty()
                           ? "cannot be read: its type " + topic.type_name + " " + topic.error_text()
                           : "no such field (wanted for " + map_key + "); near: " + nearest_names(names(), name));
  }
  out.values = *values;
  require_mostly_sound(out.values, name);
  return out;
}

std::vector<std::string> RosLog::names() const {
  std::vector<std::string> out;
  for (auto& [name, topic] : topics_) {
    topic.decode(start_s_);
    if (out.size() < kMaxNames) {
      out.push_back(name + ".time");
    }
    for (const std::string& field : topic.names()) {
      if (out.size() < kMaxNames) {
        out.push_back(name + "." + field);
      }
    }
  }
  return out;
}

std::vector<TopicSummary> RosLog::topics() const {
  std::vector<TopicSummary> out;
  for (auto& [name, topic] : topics_) {
    topic.decode(start_s_);
    out.push_back(summary_of(name, topic.type_name, topic.times(), topic.names(), topic.counter()));
  }
  return out;
}

}  // namespace m100::lab::logs
