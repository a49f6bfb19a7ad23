// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/session.h"

#include <gtest/gtest.h>

#include <vector>

#include "protocol/aes256.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame_parser.h"

namespace m100::protocol {
namespace {

using std::chrono::milliseconds;
constexpr core::TimePoint kStart{};
constexpr RequestOptions kThrice{.timeout = milliseconds(100), .transmissions = 3};
const std::array<std::byte, 1> kObtain{std::byte{1}};

std::vector<std::byte> copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

Message ack(std::uint8_t session, std::uint16_t sequence) {
  Message message;
  message.header = {.session = session, .is_ack = true, .sequence = sequence};
  return message;
}

FrameHeader command(std::uint8_t session, std::uint16_t sequence) { return {.session = session, .sequence = sequence}; }

// Catches a client that retries for ever, gives up silently, or gives the retry a new sequence number.
TEST(RequestSessions, RepeatsTheIdenticalBytesAndThenReportsTheFailure) {
  RequestSessions sessions;
  const auto first = sessions.request(ids::kControlRequest, kObtain, kThrice, kStart);
  ASSERT_TRUE(first);
  const std::vector<std::byte> bytes = copy(first->bytes);
  EXPECT_EQ(sessions.poll(kStart + milliseconds(100)).status(), core::Status::kNotReady) << "not later than asked";
  for (int sent = 2; sent <= 3; ++sent) {
    const auto due = sessions.poll(kStart + milliseconds(101 * (sent - 1)));
    ASSERT_TRUE(due) << sent;
    EXPECT_EQ(due->kind, Due::Kind::kRepeat);
    EXPECT_EQ(due->transmissions, sent);
    EXPECT_EQ(copy(due->frame.bytes), bytes);
    EXPECT_EQ(sessions.poll(kStart + milliseconds(101 * (sent - 1))).status(), core::Status::kNotReady);
  }
  const auto failed = sessions.poll(kStart + milliseconds(303));
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->kind, Due::Kind::kFailed);
  EXPECT_EQ(failed->command, ids::kControlRequest);
  EXPECT_EQ(failed->transmissions, 3);
  EXPECT_EQ(sessions.poll(kStart + milliseconds(10000)).status(), core::Status::kNotReady) << "reported once";
  EXPECT_EQ(sessions.open_count(), 0U);
}

TEST(RequestSessions, AnAnswerIsTakenOnceAndOnlyByItsOwnNumbers) {
  RequestSessions sessions(500);
  ASSERT_TRUE(sessions.request(ids::kControlRequest, kObtain, kThrice, kStart));
  EXPECT_EQ(sessions.accept(ack(2, 499), kStart).status(), core::Status::kRefused) << "another number";
  EXPECT_EQ(sessions.accept(ack(3, 500), kStart).status(), core::Status::kRefused) << "another session";
  Message no_ack = ack(2, 500);
  no_ack.header.is_ack = false;
  EXPECT_EQ(sessions.accept(no_ack, kStart).status(), core::Status::kRefused);
  const auto answer = sessions.accept(ack(2, 500), kStart + milliseconds(7));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->command, ids::kControlRequest);
  EXPECT_EQ(answer->round_trip, milliseconds(7));
  EXPECT_EQ(sessions.accept(ack(2, 500), kStart).status(), core::Status::kRefused) << "doubled";
  EXPECT_EQ(sessions.stats().stray_answers, 3U);
  EXPECT_EQ(sessions.poll(kStart + milliseconds(1000)).status(), core::Status::kNotReady);
}

TEST(RequestSessions, ThirtyAreOpenAtATimeAndTheLowestFreeIsTaken) {
  RequestSessions sessions;
  for (int i = 0; i < 30; ++i) {
    const auto sent = sessions.request(ids::kTask, kObtain, kThrice, kStart);
    ASSERT_TRUE(sent);
    EXPECT_EQ(sent->session, i + 2);
    EXPECT_EQ(sent->sequence, i);
  }
  EXPECT_EQ(sessions.request(ids::kTask, kObtain, kThrice, kStart).status(), core::Status::kResourceExhausted);
  ASSERT_TRUE(sessions.accept(ack(9, 7), kStart));
  const auto again = sessions.request(ids::kTask, kObtain, kThrice, kStart);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->session, 9);
  EXPECT_EQ(again->sequence, 30) << "the refused request used no number";
}

// All sessions share one counter. It wraps, and skips the number that the session used last.
TEST(RequestSessions, SequenceWrapsAndSkipsTheLastNumberOfItsSession) {
  RequestSessions sessions(65535);
  const auto last = sessions.request(ids::kTask, kObtain, kThrice, kStart);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->sequence, 65535);
  ASSERT_TRUE(sessions.accept(ack(2, 65535), kStart));
  EXPECT_EQ(sessions.send(ids::kMovement, kObtain)->sequence, 0);
  for (int i = 1; i < 65535; ++i) {
    ASSERT_TRUE(sessions.send(ids::kMovement, kObtain));
  }
  const auto after_a_round = sessions.request(ids::kTask, kObtain, kThrice, kStart);
  ASSERT_TRUE(after_a_round);
  EXPECT_EQ(after_a_round->session, 2);
  EXPECT_EQ(after_a_round->sequence, 0);
}

TEST(RequestSessions, ShortTimeoutsCountAsTwentyMilliseconds) {
  RequestSessions sessions;
  ASSERT_TRUE(sessions.request(ids::kTask, kObtain, {.timeout = milliseconds(1), .transmissions = 2}, kStart));
  EXPECT_EQ(sessions.poll(kStart + milliseconds(20)).status(), core::Status::kNotReady);
  EXPECT_TRUE(sessions.poll(kStart + milliseconds(21)));
}

// DJI's SDK retries for ever if it is given 0.
TEST(RequestSessions, NoTransmissionsMeansOne) {
  RequestSessions sessions;
  ASSERT_TRUE(sessions.request(ids::kTask, kObtain, {.timeout = milliseconds(50), .transmissions = 0}, kStart));
  const auto due = sessions.poll(kStart + milliseconds(51));
  ASSERT_TRUE(due);
  EXPECT_EQ(due->kind, Due::Kind::kFailed);
}

TEST(RequestSessions, ACancelledRequestIsNeitherRepeatedNorReported) {
  RequestSessions sessions;
  ASSERT_TRUE(sessions.request(ids::kControlRequest, kObtain, kThrice, kStart));
  ASSERT_TRUE(sessions.request(ids::kTask, kObtain, kThrice, kStart));
  sessions.cancel(ids::kControlRequest);
  const auto due = sessions.poll(kStart + milliseconds(200));
  ASSERT_TRUE(due);
  EXPECT_EQ(due->command, ids::kTask);
  sessions.cancel(ids::kTask);
  EXPECT_EQ(sessions.poll(kStart + milliseconds(400)).status(), core::Status::kNotReady);
}

TEST(RequestSessions, FramesTooLongToKeepAreRefused) {
  RequestSessions sessions;
  const std::vector<std::byte> value(RequestSessions::kFrameBytes);
  EXPECT_EQ(sessions.request(ids::kToMobile, value, kThrice, kStart).status(), core::Status::kResourceExhausted);
  EXPECT_TRUE(sessions.send(ids::kToMobile, value)) << "session 0 keeps nothing";
  const std::vector<std::byte> no_frame(2000);
  EXPECT_FALSE(sessions.send(ids::kToMobile, no_frame)) << "no frame is so long";
}

// A frame's header has five bits for the session, but a caller's header may hold any number.
TEST(Sessions, NumbersThatThereAreNotAreRefused) {
  RequestSessions requests;
  EXPECT_EQ(requests.accept(ack(32, 1), kStart).status(), core::Status::kRefused);
  EXPECT_EQ(requests.accept(ack(255, 1), kStart).status(), core::Status::kRefused);
  AnswerSessions answers;
  EXPECT_EQ(answers.answer(command(32, 1), encode_ack(0)).status(), core::Status::kInvalidArgument);
  FrameHeader an_answer = command(5, 1);
  an_answer.is_ack = true;
  EXPECT_EQ(answers.answer(an_answer, encode_ack(0)).status(), core::Status::kInvalidArgument)
      << "answers are not answered";
  EXPECT_EQ(answers.answer(command(5, 1), encode_ack(0)).status(), core::Status::kRefused)
      << "nothing came by this number";
}

TEST(AnswerSessions, AnAnswerThatIsTooLongToKeepIsRefused) {
  AnswerSessions sessions;
  ASSERT_EQ(sessions.accept(command(5, 1)).verdict, AnswerSessions::Verdict::kExecute);
  const std::vector<std::byte> value(2000);
  EXPECT_FALSE(sessions.answer(command(5, 1), value));
  EXPECT_TRUE(sessions.answer(command(5, 1), encode_ack(0))) << "a shorter one still may";
}

// Catches an autopilot that takes off twice because an answer was lost.
TEST(AnswerSessions, ExecutesANumberOnceAndRepeatsTheStoredAnswer) {
  AnswerSessions sessions;
  EXPECT_EQ(sessions.accept(command(5, 100)).verdict, AnswerSessions::Verdict::kExecute);
  EXPECT_EQ(sessions.accept(command(5, 100)).verdict, AnswerSessions::Verdict::kIgnore) << "not answered yet";
  const auto answer = sessions.answer(command(5, 100), encode_ack(2));
  ASSERT_TRUE(answer);
  const std::vector<std::byte> bytes = copy(answer->bytes);
  for (int i = 0; i < 3; ++i) {
    const auto again = sessions.accept(command(5, 100));
    EXPECT_EQ(again.verdict, AnswerSessions::Verdict::kRepeat);
    EXPECT_EQ(copy(again.bytes), bytes);
  }
  EXPECT_EQ(sessions.accept(command(6, 100)).verdict, AnswerSessions::Verdict::kExecute) << "another session";
  EXPECT_EQ(sessions.accept(command(5, 101)).verdict, AnswerSessions::Verdict::kExecute) << "another number";
  EXPECT_EQ(sessions.accept(command(5, 101)).verdict, AnswerSessions::Verdict::kIgnore) << "never the old answer";
  EXPECT_EQ(sessions.answer(command(5, 100), encode_ack(2)).status(), core::Status::kRefused) << "too late";
}

TEST(AnswerSessions, SessionsZeroAndOneAreExecutedEachTime) {
  AnswerSessions sessions;
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(sessions.accept(command(0, 1)).verdict, AnswerSessions::Verdict::kExecute);
    EXPECT_EQ(sessions.accept(command(1, 1)).verdict, AnswerSessions::Verdict::kExecute);
    EXPECT_TRUE(sessions.answer(command(1, 1), encode_ack(0)));
  }
  EXPECT_EQ(sessions.answer(command(0, 1), encode_ack(0)).status(), core::Status::kInvalidArgument);
}

// Without the key with which the autopilot encrypts, we answer unencrypted.
TEST(AnswerSessions, MirrorsTheEncryptionOfTheCommandWhereItHasTheKey) {
  const Aes256 key(CipherKey{7});
  for (const Cipher* const cipher : {static_cast<const Cipher*>(&key), static_cast<const Cipher*>(nullptr)}) {
    AnswerSessions sessions;
    FrameHeader to = command(4, 9);
    to.encryption = 1;
    (void)sessions.accept(to);
    const auto answer = sessions.answer(to, encode_ack(2), cipher);
    ASSERT_TRUE(answer);
    FrameParser parser;
    ASSERT_EQ(parser.push(answer->bytes), answer->bytes.size());
    const auto frame = parser.poll();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->header.encrypted(), cipher != nullptr);
    CipherScratch scratch;
    EXPECT_EQ(*decode_ack(open(*frame, cipher, scratch)->value), 2);
  }
}

TEST(AnswerSessions, AfterARestartEverythingIsNew) {
  AnswerSessions sessions;
  (void)sessions.accept(command(5, 100));
  ASSERT_TRUE(sessions.answer(command(5, 100), encode_ack(2)));
  sessions.reset();
  EXPECT_EQ(sessions.accept(command(5, 100)).verdict, AnswerSessions::Verdict::kExecute);
}

}  // namespace
}  // namespace m100::protocol
