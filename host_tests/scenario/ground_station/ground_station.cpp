// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/ground_station/ground_station.h"

#include <time.h>
#include <unistd.h>

#include <stdexcept>
#include <utility>

namespace m100::ground_station {
namespace {

enum End : sim::LockstepHost::End { kClient, kAutopilot, kPose };
constexpr double kStart_s = 60.0;  // real time for a program to start on a busy machine

/// An hour ahead of this machine's clock, so that the time a program takes to start cannot make a stamp too old.
mavlink::SignatureTime first_stamp() {
  constexpr std::int64_t kHour_s = 3600;
  return static_cast<mavlink::SignatureTime>(::time(nullptr) + kHour_s - mavlink::kSignatureEpoch_s) *
         mavlink::kSignatureTicksPerSecond;
}

}  // namespace

GroundStation::GroundStation(std::filesystem::path folder, std::uint64_t seed)
    : folder_(std::move(folder)), random_(seed, "room"), m100_port_(Socket().port()), last_stamp_(first_stamp()) {
  for (const char* const name : {"port", "n1", "n1_pose"}) {
    (void)host_.add_end((folder_ / name).string());
  }
}

std::string GroundStation::key_text() {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const std::byte byte : kKey) {
    text += kDigits[std::to_integer<unsigned>(byte) / 16];
    text += kDigits[std::to_integer<unsigned>(byte) % 16];
  }
  return text;
}

void GroundStation::start_autopilot(const std::filesystem::path& events, const std::vector<std::string>& more) {
  const std::string line = "sim:" + (folder_ / "n1").string();
  const Words words{"autopilot", "--pty",         line,         "--pose-pty", line + "_pose",
                    "--events",  events.string(), "--duration", "600"};
  autopilot_ = std::make_unique<scenario::Process>(M100_LAB_PROGRAM, with(words, more));
  if (!host_.wait_for([this] { return host_.is_attached(autopilot_->id()); }, kStart_s)) {
    throw std::runtime_error("the autopilot did not start");
  }
}

bool GroundStation::start(const std::vector<std::string>& words, const std::filesystem::path& errors) {
  program_ = std::make_unique<scenario::Process>(M100_PROGRAM, words, errors);
  ending_.reset();
  const pid_t process = program_->id();
  (void)host_.wait_for(
      [&] {
        if (const int code = program_->wait(std::chrono::seconds(0)); program_->id() < 0) {
          ending_ = code;
        }
        return ending_ || host_.is_attached(process);
      },
      kStart_s);
  return !ending_;
}

mavlink::SignatureTime GroundStation::stamp() {
  const auto at = mavlink::SignatureTime(1);  // two frames of the same time differ by one
  last_stamp_ += at;
  return last_stamp_;
}

void GroundStation::deliver(const Packet& packet, mavlink::SignatureTime stamp) {
  ++network.given;
  ++(stamp > newest_given_ ? network.newer : network.not_newer);
  newest_given_ = std::max(newest_given_, stamp);
  sender_.send(m100_port_, packet);
}

Packet GroundStation::send(mavlink::Frame frame) {
  const mavlink::SignatureTime time = stamp();
  mavlink::sign(frame, kKey, kLink, time);
  Packet packet(frame.bytes().begin(), frame.bytes().end());
  recorded.push_back(packet);
  if (random_.uniform() < network.lost) {
    return packet;
  }
  if (!held_back_ && random_.uniform() < network.swapped) {
    held_back_.emplace(packet, time);
    return packet;
  }
  deliver(packet, time);
  if (random_.uniform() < network.doubled) {
    deliver(packet, time);
  }
  if (const auto late = std::exchange(held_back_, std::nullopt)) {
    deliver(late->first, late->second);
  }
  return packet;
}

void GroundStation::listen() {
  while (const std::optional<Packet> packet = sender_.receive()) {
    mavlink::Parser parser;
    parser.consume(*packet, [&](const mavlink::FrameView& frame) {
      wrongly_signed += is_signed_with(frame, kKey) ? 0U : 1U;
      if (on_frame) {
        on_frame(frame);
      }
    });
  }
}

void GroundStation::step() {
  constexpr core::Duration kStep = std::chrono::milliseconds(5);
  const core::TimePoint before = host_.now();
  host_.advance(before + kStep);
  last_stamp_ += static_cast<mavlink::SignatureTime>((host_.now() - before).count()) / 10;
  host_.give(kClient, host_.take(kAutopilot));
  host_.give(kAutopilot, host_.take(kClient));
  poses_.consume(host_.take(kPose), [&](const mavlink::FrameView& frame) {
    if (!mavlink::is<mavlink::AttPosMocap>(frame)) {
      return;
    }
    const auto pose = mavlink::decode<mavlink::AttPosMocap>(frame);
    if (on_pose) {
      on_pose(pose);
    }
    if (sends_poses) {
      (void)send(mavlink::encode(pose, kSender, frames++));
    }
  });
  listen();
}

bool GroundStation::run_until(const std::function<bool()>& condition, double at_most_s) {
  for (const double end_s = now_s() + at_most_s; now_s() < end_s && !ending_;) {
    if (condition()) {
      return true;
    }
    step();
    if (const int code = program_->wait(std::chrono::seconds(0)); program_->id() < 0) {
      ending_ = code;
    }
  }
  return condition();
}

std::optional<int> GroundStation::run_to_end(double at_most_s) {
  (void)run_until([] { return false; }, at_most_s);
  if (!ending_) {  // it may have left simulated time, but not yet have ended in real time
    if (const int code = program_->wait(); program_->id() < 0) {
      ending_ = code;
    }
  }
  return ending_;
}

}  // namespace m100::ground_station
