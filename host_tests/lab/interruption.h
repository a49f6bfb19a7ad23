// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <signal.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <string>

// What happens at Ctrl-C: the program says how to go on, and the child that works for it ends too.
namespace m100::lab {

struct Interruption {
  std::string text;             ///< printed to standard error
  std::atomic<pid_t> child{0};  ///< 0: none runs
};

inline Interruption& interruption() {
  static Interruption one;
  return one;
}

/// From now on SIGINT prints the text, ends the running child, and then ends the program as SIGINT does without a
/// handler.
inline void explain_interruption(std::string text) {
  if (::signal(SIGINT, SIG_DFL) == SIG_IGN) {  // who started us wants that
    ::signal(SIGINT, SIG_IGN);
    return;
  }
  interruption().text = std::move(text);
  ::signal(SIGINT, [](int) {
    if (const pid_t child = interruption().child.load(); child > 0) {
      ::kill(child, SIGTERM);
    }
    const std::string& said = interruption().text;
    static_cast<void>(!::write(STDERR_FILENO, said.data(), said.size()));
    ::signal(SIGINT, SIG_DFL);
    ::raise(SIGINT);
  });
}

}  // namespace m100::lab
