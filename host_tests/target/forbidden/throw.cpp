// SPDX-License-Identifier: BSD-3-Clause
int main(int argc, char**) {
  if (argc > 1) {
    throw argc;
  }
  return 0;
}
