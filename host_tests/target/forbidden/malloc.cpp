// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>

int main(int argc, char**) { return std::malloc(static_cast<unsigned>(argc)) == nullptr ? 1 : 0; }
