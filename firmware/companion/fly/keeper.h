// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <string>

#include "firmware/link/farewell.h"
#include "hal/linux/simulated_port.h"

namespace m100::companion {

struct KeeperBoard;

/// The second process of a flight (promise R15). It holds the port and the farewell, ready-made, and says it when the
/// flying program has died without a word (SIGKILL, SIGSEGV, out of memory, an assertion) or has not beaten for kHang
/// (a hang, SIGSTOP). It allocates nothing and reads nothing that comes over the port.
///
/// The same process, forked early: before it there are no threads, and little memory to lose to a hunter of memory. It
/// is in a session of its own, deaf to every signal that can be ignored, so Ctrl-C, a closed terminal and `kill 0` pass
/// it by. Told to go, it ends at once; after the death of the program it ends with its last word, and with it the lock
/// on the port.
///
/// It speaks and the program beats by one atomic word: after the keeper has decided to speak, the next beat() fails,
/// and a beat() that succeeded is good for kHang. So the two never speak at the same time.
class Keeper {
 public:
  static constexpr core::Duration kHang = std::chrono::milliseconds(700);  ///< without a beat, after the first one
  static constexpr core::Duration kLook = std::chrono::milliseconds(20);   ///< between two looks at the beats
  /// Between two rounds, of two releases each: promise R4, at most five times a second.
  static constexpr core::Duration kRepeat = std::chrono::milliseconds(500);
  static constexpr std::size_t kRounds = 4;  ///< of the farewell: the line may be bad, answers are not read

  /// Starts the second process and waits until it says that it stands: what is asked for afterwards is given back
  /// whenever this program dies. @param neutral command of the channel in use. @param cipher null: plain.
  /// Errors: std::runtime_error where the system has no room for a process, or it does not come up: then nothing flies.
  /// @param port whose time it lives in; a simulated one brings its own.
  Keeper(const link::ChannelCommand& neutral, const protocol::Cipher* cipher, const std::string& port = "");
  /// Before the first beat it dismisses the keeper; after it, an exception is on its way, and the keeper speaks.
  ~Keeper();
  Keeper(const Keeper&) = delete;
  Keeper& operator=(const Keeper&) = delete;

  /// The port's descriptor as it is now, each tick; -1: it is closed. The keeper lets go of a port that was unplugged,
  /// so that it can come back under its name. No heap; costs a system call when something has changed.
  /// @param openings SerialPort::openings(), which tells two ports with one number apart.
  void hold(int descriptor, std::uint32_t openings);

  /// "I am alive", each tick, before anything is sent. @param in_control commands may be in force.
  /// @returns false, once: the keeper has spoken since the beat before; control is given back, and must not be used.
  bool beat(bool in_control);

  /// False: it was killed, so nobody would speak. Reaps it.
  bool alive();

  enum class Guard : std::uint8_t { kStands, kStandsStill, kDead };
  /// Each tick: whether somebody would speak if this program died now. One that was stopped, or gets no time, has not
  /// looked for kHang. A system call only where it has not.
  Guard guard(core::TimePoint now);

  /// The flight is over and control is back: the keeper ends. Waits for its end.
  void dismiss();

  /// The flight is over, and control may still be ours, or granted later: the keeper says its rounds and ends. Waits
  /// for its end, two seconds.
  void speak();

  pid_t process() const { return process_; }

 private:
  bool comes_up();
  void end(char letter, core::Duration patience);

  hal::PortClock clock_;
  KeeperBoard* board_ = nullptr;
  int socket_ = -1;
  pid_t process_ = -1;
  int held_ = -1;
  std::uint32_t openings_ = 0;
  std::uint32_t seen_looks_ = 0;
  core::TimePoint seen_at_{};
};

}  // namespace m100::companion
