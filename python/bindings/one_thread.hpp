// Objects that one thread at a time may use: a call from a second thread raises ContractError instead of racing.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <type_traits>
#include <utility>

#include "bindings.hpp"

/// Who may use an object now. Calls may be nested on one thread; a second thread gets ContractError with `mistake`.
class OneThread {
 public:
  explicit OneThread(const char* mistake) : mistake_(mistake) {}

  /// One call in progress.
  class Use {
   public:
    explicit Use(OneThread& guard) : guard_(guard) { guard_.enter(); }
    ~Use() { guard_.leave(); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    OneThread& guard_;
  };

  /// The calling thread alone may use the object, between calls too, until `release`. Twice is as good as once.
  void claim() {
    const Use use(*this);
    if (!std::exchange(claimed_, true)) ++depth_;
  }
  /// Any thread may be the next. For the owner, or for any caller once the owner's event loop is closed.
  void release() {
    if (std::exchange(claimed_, false)) leave();
  }

 private:
  void enter() {
    const std::thread::id me = std::this_thread::get_id();
    std::thread::id none;
    if (user_.load() != me && !user_.compare_exchange_strong(none, me)) throw threewe::ContractError(mistake_);
    ++depth_;
  }
  void leave() {
    if (--depth_ == 0) user_.store({});
  }

  const char* mistake_;
  std::atomic<std::thread::id> user_;
  int depth_ = 0;         // what only the user reads and writes
  bool claimed_ = false;  // likewise
};

/// What the error in a second thread says; specialize it where more is to be said.
template <class T>
inline constexpr const char* kSecondThread = "it is in use on another thread, and one thread at a time may use it";

/// A T with its guard, as Python owns it: bind it as `OneThreadClass<Guarded<T>>`.
template <class T>
struct Guarded : T {
  using T::T;
  explicit Guarded(T&& object) : T(std::move(object)) {}

  mutable OneThread one_thread{kSecondThread<T>};
};

/// The guard of an object; specialize it for objects that another one guards, such as a robot's world.
template <class T>
OneThread& thread_of(const T& object) {
  return object.one_thread;
}

/// An nb::class_ whose methods and properties refuse a second thread. Constructors, static methods and what is bound
/// with `def_ro` are not guarded: bind so only what never changes.
template <class T, class... Base>
class OneThreadClass : public nb::class_<T, Base...> {
  using Class = nb::class_<T, Base...>;

 public:
  using Class::Class;

  template <class Function, class... Extra>
  OneThreadClass& def(const char* name, Function&& function, const Extra&... extra) {
    Class::def(name, guarded(std::forward<Function>(function)), extra...);
    return *this;
  }
  template <class... Args, class... Extra>
  OneThreadClass& def(nb::init<Args...> init, const Extra&... extra) {
    Class::def(std::move(init), extra...);
    return *this;
  }
  template <class Getter, class... Extra>
  OneThreadClass& def_prop_ro(const char* name, Getter&& get, const Extra&... extra) {
    Class::def_prop_ro(name, guarded(std::forward<Getter>(get)), extra...);
    return *this;
  }

 private:
  // The signature of a lambda, a function or a method, as a std::function of the object and the arguments.
  template <class R, class C, class... Args>
  static std::function<R(T&, Args...)> signature(R (C::*)(Args...));
  template <class R, class C, class... Args>
  static std::function<R(const T&, Args...)> signature(R (C::*)(Args...) const);
  template <class Lambda>
  static auto signature(const Lambda& lambda) -> decltype(std::function{lambda});

  template <class Function>
  static auto guarded(Function&& function) {
    using Signature = decltype(signature(function));
    return wrap(std::forward<Function>(function), static_cast<Signature*>(nullptr));
  }
  template <class Function, class R, class Self, class... Args>
  static auto wrap(Function&& function, std::function<R(Self, Args...)>*) {
    if constexpr (std::is_pointer_v<Self>) {
      return std::forward<Function>(function);  // a constructor: there is no object yet
    } else {
      return [function = std::forward<Function>(function)](T& self, Args... args) -> R {
        const OneThread::Use use(thread_of(self));
        return std::invoke(function, self, std::forward<Args>(args)...);
      };
    }
  }
};
