// SPDX-License-Identifier: BSD-3-Clause
// Both sides of the sessions over a line that loses, doubles and delays frames; a record of all events checks them.
#include "protocol/dji/session.h"

#include <gtest/gtest.h>

#include <deque>
#include <map>

#include "host_tests/property/protocol/streams.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame_parser.h"

namespace m100::host_tests {
namespace {

using namespace protocol;
using std::chrono::milliseconds;

struct OnTheLine {
  core::TimePoint arrives;
  Bytes bytes;
};

/// Loses, doubles and delays frames, so that they overtake each other.
class Line {
 public:
  Line(double loss, std::mt19937& random) : loss_(loss), random_(random) {}

  void write(std::span<const std::byte> bytes, core::TimePoint now) {
    for (int copy = random_() % 10 == 0 ? 2 : 1; copy > 0; --copy) {
      if (std::uniform_real_distribution(0., 1.)(random_) >= loss_) {
        const core::TimePoint arrives = now + milliseconds(random_() % 40);
        queue_.push_back({arrives, Bytes(bytes.begin(), bytes.end())});
      }
    }
  }

  template <typename OnFrame>
  void read(core::TimePoint now, OnFrame&& on_frame) {
    std::deque<OnTheLine> waiting;
    std::swap(waiting, queue_);
    for (const OnTheLine& each : waiting) {
      if (each.arrives <= now) {
        parser_.consume(each.bytes, on_frame);
      } else {
        queue_.push_back(each);
      }
    }
  }

 private:
  double loss_;
  std::mt19937& random_;
  std::deque<OnTheLine> queue_;
  FrameParser parser_;
};

struct Outcome {
  int executed = 0;
  int answered = 0;
  int failed = 0;
  int sent = 0;
};

/// The two sides, and the number of outcomes of each request.
class Exchange {
 public:
  Exchange(double loss, unsigned seed) : random_(seed), up_(loss, random_), down_(loss, random_) {}

  void run(int requests) {
    core::TimePoint now{};
    for (int started = 0; started < requests || client_.open_count() > 0; now += milliseconds(1)) {
      if (started < requests && random_() % 3 == 0) {
        started += start(started, now);
      }
      up_.read(now, [&](const FrameView& frame) { serve(frame, now); });
      down_.read(now, [&](const FrameView& frame) { take_answer(frame, now); });
      for (auto due = client_.poll(now); due; due = client_.poll(now)) {
        repeat(*due, now);
      }
      ASSERT_LT(now.time_since_epoch(), std::chrono::hours(1)) << "a request stays open for ever";
    }
  }

  const std::map<int, Outcome>& outcomes() const { return outcomes_; }

 private:
  int start(int number, core::TimePoint now) {
    std::array<std::byte, 4> value;
    std::memcpy(value.data(), &number, sizeof(number));
    const RequestOptions options{.timeout = milliseconds(20 + random_() % 80), .transmissions = 3};
    const auto sent = client_.request(ids::kToMobile, value, options, now);
    if (!sent) {
      EXPECT_EQ(sent.status(), core::Status::kResourceExhausted);
      EXPECT_EQ(client_.open_count(), 30U);
      return 0;
    }
    open_[{sent->session, sent->sequence}] = number;
    outcomes_[number].sent = 1;
    up_.write(sent->bytes, now);
    return 1;
  }

  void serve(const FrameView& frame, core::TimePoint now) {
    const AnswerSessions::Reception reception = server_.accept(frame.header);
    if (reception.verdict == AnswerSessions::Verdict::kRepeat) {
      down_.write(reception.bytes, now);
    }
    if (reception.verdict == AnswerSessions::Verdict::kExecute) {
      ++outcomes_[load<int>(frame.data.data() + 2)].executed;
      down_.write(server_.answer(frame.header, encode_ack(0))->bytes, now);
    }
  }

  void take_answer(const FrameView& frame, core::TimePoint now) {
    CipherScratch scratch;
    const auto message = open(frame, nullptr, scratch);
    if (const auto answer = client_.accept(*message, now); answer) {
      ++outcomes_[open_.at({answer->session, answer->sequence})].answered;
    }
  }

  void repeat(const Due& due, core::TimePoint now) {
    Outcome& outcome = outcomes_[open_.at({due.frame.session, due.frame.sequence})];
    if (due.kind == Due::Kind::kFailed) {
      ++outcome.failed;
    } else {
      ++outcome.sent;
      up_.write(due.frame.bytes, now);
    }
  }

  std::mt19937 random_;
  Line up_;
  Line down_;
  RequestSessions client_{65000};  // the counter wraps during the test
  AnswerSessions server_;
  std::map<std::pair<std::uint8_t, std::uint16_t>, int> open_;
  std::map<int, Outcome> outcomes_;
};

// On any line, each request must end exactly once, in an answer or a reported failure, after at most three
// transmissions. An answered request must have been executed.
TEST(Sessions, EveryRequestEndsOnce) {
  for (const double loss : {0., 0.01, 0.3, 0.8, 1.}) {
    for (unsigned seed = 0; seed < 10; ++seed) {
      Exchange exchange(loss, seed);
      exchange.run(400);
      ASSERT_EQ(exchange.outcomes().size(), 400U);
      for (const auto& [number, outcome] : exchange.outcomes()) {
        ASSERT_EQ(outcome.answered + outcome.failed, 1) << number << ", loss " << loss << ", seed " << seed;
        ASSERT_LE(outcome.sent, 3);
        ASSERT_GE(outcome.executed, outcome.answered);
      }
    }
  }
}

/// A client that repeats requests, and a server half of whose answers are lost.
class ForgetfulLine {
 public:
  explicit ForgetfulLine(unsigned seed) : random_(seed), client_(static_cast<std::uint16_t>(random_())) {}

  void step(core::TimePoint now) {
    for (const Bytes& bytes : written(now)) {
      to_server_.consume(bytes, [&](const FrameView& frame) { serve(frame, now); });
    }
  }

 private:
  std::vector<Bytes> written(core::TimePoint now) {
    std::vector<Bytes> all;
    if (const auto sent = client_.request(ids::kTask, Bytes(2), {milliseconds(50), 5}, now); sent) {
      all.emplace_back(sent->bytes.begin(), sent->bytes.end());
    }
    for (auto due = client_.poll(now); due; due = client_.poll(now)) {
      all.emplace_back(due->frame.bytes.begin(), due->frame.bytes.end());
    }
    return all;
  }
  void serve(const FrameView& frame, core::TimePoint now) {
    const auto reception = server_.accept(frame.header);
    std::span<const std::byte> answer = reception.bytes;
    if (reception.verdict == AnswerSessions::Verdict::kExecute) {
      ASSERT_EQ(++executed_[(std::uint32_t{frame.header.session} << 16U) + frame.header.sequence], 1);
      answer = server_.answer(frame.header, encode_ack(2))->bytes;
    }
    if (random_() % 2 == 0) {
      FrameParser to_client;
      to_client.consume(answer, [&](const FrameView& ack) {
        CipherScratch scratch;
        (void)client_.accept(*open(ack, nullptr, scratch), now);
      });
    }
  }

  std::mt19937 random_;
  RequestSessions client_;
  AnswerSessions server_;
  FrameParser to_server_;
  std::map<std::uint32_t, int> executed_;
};

// On a line that keeps the order (no frame overtakes another one of its session), nothing may be executed twice.
TEST(Sessions, NothingIsExecutedTwice) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    ForgetfulLine line(seed);
    core::TimePoint now{};
    for (int step = 0; step < 500; ++step, now += milliseconds(30)) {
      line.step(now);
    }
  }
}

}  // namespace
}  // namespace m100::host_tests
