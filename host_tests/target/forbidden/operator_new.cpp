// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

int main(int argc, char**) {
  std::vector<int> grows;
  grows.push_back(argc);
  return grows.back();
}
