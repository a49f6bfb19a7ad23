// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/regimes.h"
#include "host_tests/lab/printed.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace m100::lab::identify {
namespace {

constexpr double kBlock_s = 2.5;  // of every family

std::vector<Range> clipped(const std::vector<Range>& ranges, Range to) {
  std::vector<Range> out;
  for (const Range& range : ranges) {
    const Range cut{std::max(range.first, to.first), std::min(range.second, to.second)};
    if (cut.second - cut.first >= kBlock_s) {
      out.push_back(cut);
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

double length_s(const std::vector<Range>& ranges) {
  return std::accumulate(ranges.begin(), ranges.end(), 0.0,
                         [](double sum, const Range& range) { return sum + range.second - range.first; });
}

constexpr double kMinTraining_s = 5.0 * kBlock_s;

bool enough(const Request& side) { return length_s(side.train) >= kMinTraining_s && !side.validate.empty(); }

/// Divides the side again, two thirds for training and one for validation, where a change left too little of either.
void split_again(Request& side) {
  std::vector<Range> all = side.train;
  all.insert(all.end(), side.validate.begin(), side.validate.end());
  std::sort(all.begin(), all.end());
  if (all.empty()) {
    return;
  }
  const double from_s = all.front().first;
  const double split_s = from_s + 2.0 / 3.0 * (all.back().second - from_s);
  side.train = clipped(all, {from_s, split_s});
  side.validate = clipped(all, {split_s, all.back().second});
}

}  // namespace

std::vector<Request> regimes_of(const Request& request, const Change& change) {
  const bool one_log = in_one_log(request);
  std::vector<Request> out;
  double most_s = 0.0;
  for (const Range& side : {Range{-1e9, change.low_s}, Range{change.high_s, 1e9}}) {
    Request cut = request;
    cut.train = clipped(request.train, side);
    cut.validate = one_log ? clipped(request.validate, side) : request.validate;
    const double whole_s = length_s(cut.train) + (one_log ? length_s(cut.validate) : 0.0);
    if (one_log && !enough(cut)) {
      split_again(cut);
    }
    if (enough(cut)) {
      out.insert(whole_s > most_s ? out.begin() : out.end(), std::move(cut));
      most_s = std::max(most_s, whole_s);
    }
  }
  return out;
}

void add_change(SideFindings& side_findings, const Change& change) {
  if (!change.rivals.empty()) {
    std::string names = change.name;
    for (const std::string& rival : change.rivals) {
      names += " or " + rival;
    }
    side_findings.unexplained.push_back("a change in mid-flight without a certain name: " + names);
  }
  side_findings.changes.push_back(change);
}

Finding regime_note(const Request& side) {
  return note(printed("effects, errors and intervals are from one side of the change only: %.1f to %.1f s",
                      side.train.front().first, side.validate.back().second));
}

}  // namespace m100::lab::identify
