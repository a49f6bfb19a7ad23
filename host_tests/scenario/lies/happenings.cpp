// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/lies/happenings.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace m100::scenario {
namespace {

constexpr std::size_t kMostHappenings = 6;

double drawn_value(Word word, sim::Random& random) {
  switch (word) {
    case Word::kLoseAcks:
    case Word::kDoubleAcks:
      return static_cast<double>(1 + random.next() % 5);
    case Word::kDelayAcks:
    case Word::kSaysOurs:
    case Word::kSaysPilots:
    case Word::kSaysMode:
      return 0.02 * std::pow(200.0, random.uniform());  // seconds
    default:
      return 0.0;
  }
}

Happening drawn_happening(bool operators, double within_s, sim::Random& random) {
  const std::size_t first = operators ? 0 : kOperatorWords;
  const std::size_t count = operators ? kOperatorWords : kWords.size() - kOperatorWords;
  Happening happening;
  happening.word = static_cast<Word>(first + random.next() % count);
  happening.at_s = within_s * random.uniform();
  happening.value = drawn_value(happening.word, random);
  return happening;
}

}  // namespace

std::string to_text(const Happenings& happenings) {
  std::ostringstream out;
  out.precision(4);
  for (std::size_t i = 0; i < happenings.size(); ++i) {
    const Happening& one = happenings[i];
    out << (i > 0 ? "; " : "") << kWords[static_cast<std::size_t>(one.word)] << " " << one.at_s << " " << one.value;
  }
  return out.str();
}

Happenings happenings_of(const std::string& text) {
  Happenings happenings;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ';');) {
    std::istringstream words(part);
    std::string word;
    Happening one;
    words >> word >> one.at_s >> one.value;
    const auto* const found = std::find(kWords.begin(), kWords.end(), word);
    if (words.fail() || found == kWords.end()) {
      throw std::invalid_argument("unknown happening: " + part);
    }
    one.word = static_cast<Word>(found - kWords.begin());
    happenings.push_back(one);
  }
  return happenings;
}

Happenings drawn_happenings(bool operators, double within_s, sim::Random& random) {
  Happenings happenings;
  for (std::size_t count = 1 + random.next() % kMostHappenings; count > 0; --count) {
    happenings.push_back(drawn_happening(operators, within_s, random));
  }
  return happenings;
}

Happenings neighbour_of(const Happenings& happenings, bool operators, double within_s, sim::Random& random) {
  Happenings next = happenings;
  Happening& one = next[random.next() % next.size()];
  const double dice = random.uniform();
  if (dice < 0.2 && next.size() < kMostHappenings) {
    next.push_back(drawn_happening(operators, within_s, random));
  } else if (dice < 0.4 && next.size() > 1) {
    one = next.back();
    next.pop_back();
  } else if (dice < 0.7) {
    one.at_s = std::clamp(one.at_s + random.normal(), 0.0, within_s);
  } else {
    one = drawn_happening(operators, within_s, random);
  }
  return next;
}

}  // namespace m100::scenario
