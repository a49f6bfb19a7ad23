// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/campaign/campaign.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

namespace m100::lab::campaign {
namespace {

/// Names a flight, for the beginning of the message about its failed physics program.
std::string where(const Campaign& campaign, std::size_t number) {
  return campaign.world_of(number).path + ": " + std::string(campaign.task_of(number).name) + ", seed " +
         std::to_string(campaign.seed_of(number)) + ": ";
}

}  // namespace

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
  std::exception_ptr wrong;
  const auto fly_number = [&](std::size_t number, sim::BodyJob& body) {
    return fly_one(campaign.world_of(number).plant, campaign.task_of(number), campaign.seed_of(number),
                   campaign.settings, campaign.settings.body.is_identified() ? nullptr : &body);
  };
  const auto work = [&] {
    sim::BodyJob body(campaign.settings.body);
    for (std::size_t at = next++; at < flown.size(); at = next++) {
      try {
        flown[at].outcome = fly_number(flown[at].number, body);
      } catch (const sim::PhysicsError& failed_physics) {
        const std::lock_guard lock(counting);
        wrong = std::make_exception_ptr(sim::PhysicsError(where(campaign, flown[at].number) + failed_physics.what()));
        next = flown.size();  // the other threads finish their flights
        return;
      }
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
  if (wrong) {
    std::rethrow_exception(wrong);
  }
  return flown;
}

}  // namespace m100::lab::campaign
