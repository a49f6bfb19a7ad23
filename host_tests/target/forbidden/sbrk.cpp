// SPDX-License-Identifier: BSD-3-Clause
extern "C" void* _sbrk(int bytes) {
  static char arena[64];
  return arena + bytes;
}

int main(int argc, char**) { return _sbrk(argc) == nullptr ? 1 : 0; }
