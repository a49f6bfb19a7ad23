// SPDX-License-Identifier: BSD-3-Clause
#include <typeinfo>

struct Base {
  virtual int value() const { return 1; }
};
struct Derived : Base {
  int value() const override { return 2; }
};

int main(int argc, char**) {
  const Base base;
  const Derived derived;
  const Base& chosen = argc > 1 ? derived : base;
  return typeid(chosen) == typeid(Derived) ? chosen.value() : 0;
}
