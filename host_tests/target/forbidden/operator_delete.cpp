// SPDX-License-Identifier: BSD-3-Clause
struct Base {
  virtual ~Base() = default;
};
struct Derived : Base {
  ~Derived() override;
};
Derived::~Derived() = default;

int main() {
  Derived on_the_stack;  // its virtual destructor has a deleting form, which calls operator delete
  const Base& seen = on_the_stack;
  return *reinterpret_cast<void* const*>(&seen) == nullptr ? 1 : 0;
}
