// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/assert.h"
#include "firmware/core/time.h"
#include "firmware/mpc/gain_table.h"

namespace m100::mpc {

/// The observer's estimate of one axis now. Tilt and tilt rate are those of the attitude, as slopes (see Problem).
template <typename T>
struct AxisState {
  T position_m{0};
  T velocity_m_s{0};
  T tilt_slope{0};
  T tilt_slope_per_s{0};
  T disturbance_m_s2{0};
  T input_offset_slope{0};
};

/// Predicts one axis through its transport delay D from the inputs already sent.
///
/// An input sent at tick k acts on the vehicle from t_k + D to t_{k+1} + D. With D = (n + f) 10 ms, 0 <= f < 1, the
/// inputs that act between now and now + D are u_{k-n-1} for f * 10 ms, then u_{k-n}, ..., u_{k-1}: all known. The MPC
/// starts at now + D, where its input begins to act, so its tables need no delay. The caller shifts the reference
/// window by D. Model: the axis' linear model, disturbance constant. Cost: n + 1 products of 4 x 6. No allocation; D <=
/// 0.3 s.
template <typename T>
class DelayPredictor {
 public:
  static constexpr std::size_t kCapacity = 32;

  /// The model must outlive the predictor, and its delay must fit into the delay line: ticks + 1 < kCapacity.
  explicit DelayPredictor(const DelayModel<T>& model) : model_(&model) {
    M100_ASSERT(model.ticks + 1 < kCapacity && model.delay_s >= T(0));
  }

  /// Records the input that was in force during the last tick, as it was sent after the supervisor. Call it before
  /// predict(), once for each 10 ms, however late a tick is.
  void sent(T input_slope) {
    newest_ = (newest_ + 1) % kCapacity;
    input_slopes_[newest_] = input_slope;
  }
  /// As if `input_slope` had been sent for ever.
  void reset(T input_slope = T(0)) { input_slopes_.fill(input_slope); }
  /// The input of `ticks_ago` ticks ago; 1 is the newest that was sent, kCapacity the oldest that is kept.
  T sent_ago(std::size_t ticks_ago) const {
    M100_ASSERT(ticks_ago - 1 < kCapacity);
    return input_slopes_[(newest_ + kCapacity + 1 - ticks_ago) % kCapacity];
  }

  /// How far ahead predict() looks: the transport delay.
  core::Duration lead() const {
    return core::Duration(static_cast<core::Duration::rep>(model_->delay_s * T(1000000) + T(0.5)));
  }

  /// The model's states (Problem::state) at now + lead().
  std::array<T, kMaxStates> predict(const AxisState<T>& now) const {
    const T offset = now.input_offset_slope;
    std::array<T, kMaxStates> state = model_states(now, sent_ago(model_->ticks + 1) + offset);
    state = step(model_->rest, state, sent_ago(model_->ticks + 1) + offset, now.disturbance_m_s2);
    for (std::size_t ago = model_->ticks; ago >= 1; --ago) {
      state = step(model_->tick, state, sent_ago(ago) + offset, now.disturbance_m_s2);
    }
    return state;
  }

 private:
  std::array<T, kMaxStates> model_states(const AxisState<T>& now, T acting_slope) const {
    const LeadZero<T>& lead = model_->lead;
    T chi = now.tilt_slope;
    T chi_rate = now.tilt_slope_per_s;
    if (lead.share != T(0)) {
      chi = (now.tilt_slope - lead.share * acting_slope) / (T(1) - lead.share);
    } else if (lead.zero_s != T(0)) {
      chi_rate = lead.rate_gain * (now.tilt_slope_per_s - lead.jump * (acting_slope - now.tilt_slope));
      chi = now.tilt_slope - lead.zero_s * chi_rate;
    }
    return {now.position_m, now.velocity_m_s, chi, chi_rate};
  }

  static std::array<T, kMaxStates> step(const StepModel<T>& model, const std::array<T, kMaxStates>& state,
                                        T input_slope, T disturbance_m_s2) {
    std::array<T, kMaxStates> next;
    for (std::size_t row = 0; row < kMaxStates; ++row) {
      T sum = model.input[row] * input_slope + model.disturbance[row] * disturbance_m_s2;
      // The position acts only on itself, the velocity only on itself and the position.
      for (std::size_t col = row < 2 ? row : 2; col < kMaxStates; ++col) {
        sum += model.transition[row * kMaxStates + col] * state[col];
      }
      next[row] = sum;
    }
    return next;
  }

  const DelayModel<T>* model_;
  std::array<T, kCapacity> input_slopes_{};
  std::size_t newest_ = 0;
};

}  // namespace m100::mpc
