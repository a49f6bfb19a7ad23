// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/campaign/campaign.h"

#include <atomic>
#include <mutex>
#include <thread>

namespace m100::lab::campaign {

std::vector<Flown> fly(const Campaign& campaign, const Share& share, std::size_t jobs,
                       const std::function<void(std::size_t done, std::size_t failed)>& progress) {
  std::vector<Flown> flown;
  for (std::size_t number = share.part - 1; number < campaign.size(); number += share.parts) {
    flown.push_back({.number = number, .outcome = {}});
  }
  std::atomic<std::size_t> next = 0;
  std::size_t done = 0;
  std::size_t failed = 0;
  std::mutex counting;
  const auto work = [&] {
    for (std::size_t at = next++; at < flown.size(); at = next++) {
      const std::size_t number = flown[at].number;
      const std::size_t task = number / campaign.flights;
      flown[at].outcome =
          fly_one(campaign.worlds[task / campaign.tasks.size()].plant, campaign.tasks[task % campaign.tasks.size()],
                  campaign.first_seed + number % campaign.flights, campaign.settings);
      const std::lock_guard lock(counting);
      ++done;
      failed += flown[at].outcome.stayed ? 0U : 1U;
      if (progress) {
        progress(done, failed);
      }
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t thread = 1; thread < jobs; ++thread) {
    threads.emplace_back(work);
  }
  work();
  threads.clear();  // joins them
  return flown;
}

}  // namespace m100::lab::campaign
