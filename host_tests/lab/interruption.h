// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <signal.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <string>

// At Ctrl-C the program prints how to go on, and its child process ends too.
namespace m100::lab {

struct Interruption {
  std::string text;             ///< printed to standard error
  std::atomic<pid_t> child{0};  ///< 0: none runs
};

inline Interruption& interruption() {
  static Interruption one;
  return one;
}

/// From now on SIGINT ends the running child by SIGTERM, prints the text, and then ends the program as by default.
inline void explain_interruption(std::string text) {
  if (::signal(SIGINT, SIG_DFL) == SIG_IGN) {  // our parent process wants SIGINT ignored
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
