// SPDX-License-Identifier: BSD-3-Clause
// Every assertion here guards memory, a table or a command against a mistake of our own code: a caller that breaks the
// stated precondition ends the program before it can go on with what it would have corrupted.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <ostream>
#include <span>

#include "firmware/app/tick_timer.h"
#include "firmware/core/expected.h"
#include "firmware/log/ring.h"
#include "firmware/model/axis_step.h"
#include "firmware/model/exponential.h"
#include "firmware/model/tilt_limit.h"
#include "firmware/mpc/delay_predictor.h"
#include "firmware/ref/minimum_snap.h"
#include "firmware/safety/supervisor.h"
#include "firmware/sysid/axis_residual.h"
#include "firmware/sysid/delayed_command.h"
#include "firmware/sysid/response_fit.h"
#include "protocol/crc.h"
#include "protocol/crc_kernels.h"
#include "protocol/dji/session.h"
#include "protocol/dji/value.h"
#include "protocol/mavlink/pose_messages.h"
#include "protocol/mavlink/signature.h"

namespace m100 {
namespace {

struct Mistake {
  const char* name;
  std::function<void()> make;
};
void PrintTo(const Mistake& one, std::ostream* out) { *out << one.name; }

class Assertions : public ::testing::TestWithParam<Mistake> {};

TEST_P(Assertions, EndTheProgramBeforeOurOwnMistakeSpreads) { EXPECT_DEATH(GetParam().make(), ""); }

std::array<std::byte, 8> storage;

INSTANTIATE_TEST_SUITE_P(
    Table, Assertions,
    ::testing::Values(
        Mistake{"ARingWhoseSizeIsNoPowerOfTwo", [] { log::Ring ring(std::span(storage).first(3)); }},
        Mistake{"MoreBytesOutOfARingThanInIt",
                [] {
                  log::Ring ring(storage);
                  ring.pop(1);
                }},
        Mistake{"AnErrorWithTheCodeOfSuccess", [] { const core::Expected<int> wrong(core::Status::kOk); }},
        Mistake{"TheValueOfAnError",
                [] {
                  volatile int value = *core::Expected<int>(core::Status::kNotReady);
                  (void)value;
                }},
        Mistake{"ATiltLimitBeyondTheSeries",
                [] {
                  volatile double slope = model::slope_at_limit(0.8);
                  (void)slope;
                }},
        Mistake{"TheExponentialOfAMatrixThatIsNotANumber",
                [] { (void)model::exponential<1, double>({std::numeric_limits<double>::quiet_NaN()}); }},
        Mistake{"AStepBackwardsInTime", [] { (void)model::axis_step(model::StickAxis{}, -0.01); }},
        Mistake{"ADelayLongerThanThePipe",
                [] {
                  const mpc::DelayModel<double> model{.ticks = mpc::DelayPredictor<double>::kCapacity};
                  const mpc::DelayPredictor<double> predictor(model);
                }},
        Mistake{"ACommandOlderThanTheRing", [] { sysid::DelayedCommand<double>(1.0, 0.01); }},
        Mistake{"TheEndOfAnEmptyBlock", [] { (void)sysid::ResponseFit<double>(0.01).end(); }},
        Mistake{"AResidualWithoutAnExpectation",
                [] { const sysid::AxisResidual<double> residual(model::StickAxis{}, 0.0, 0.01); }},
        Mistake{"APathOfOnePlace",
                [] {
                  std::array<ref::Node, 1> nodes{};
                  ref::minimise_snap(nodes, {});
                }},
        Mistake{"AnEnvelopeWithoutTilt",
                [] { const safety::Supervisor<double> supervisor({}, safety::Envelope{.tilt_rad = 0.0}); }},
        Mistake{"AClockThatGoesBack",
                [] {
                  app::TickTimer timer;
                  timer.update(core::TimePoint(core::Duration(2)));
                  timer.update(core::TimePoint(core::Duration(1)));
                }},
        Mistake{"MoreZerosThanTheTable",
                [] { (void)protocol::crc32_advance(0, protocol::crc_kernels::kMaxZeros + 1); }},
        Mistake{"ASessionThatDoesNotExist",
                [] {
                  protocol::AnswerSessions sessions;
                  (void)sessions.accept({.session = protocol::kSessionCount});
                }},
        Mistake{"AValueLargerThanAnyMessage",
                [] {
                  (void)protocol::Value::of([](protocol::ByteWriter& writer) {
                    writer.put(std::array<std::uint64_t, protocol::Value::kCapacity / 8 + 1>{});
                  });
                }},
        Mistake{"AFrameReadAsAnotherMessage", [] { (void)mavlink::decode<mavlink::AttPosMocap>({}); }},
        Mistake{"TheSignatureOfAnUnsignedFrame", [] { (void)mavlink::signature_of({}); }},
        Mistake{"AFrameWithoutRoomForASignature",
                [] {
                  mavlink::Frame frame{};
                  mavlink::sign(frame, {}, 0, 0);
                }},
        Mistake{"MoreStreamsThanAreRemembered",
                [] {
                  mavlink::ReplayMemory memory{};
                  memory.count = mavlink::ReplayGuard::kStreams + 1;
                  const mavlink::ReplayGuard guard(memory);
                }}),
    [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace m100
