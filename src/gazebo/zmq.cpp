#include "gazebo/zmq.hpp"

#include <array>

#include <dlfcn.h>
#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::gazebo::zmq {
namespace {

// As zmq.h has them.
struct alignas(void*) Part {
  unsigned char opaque[64];
};
constexpr int kDoNotWait = 1;
constexpr int kSendMore = 2;
constexpr int kIdentity = 5;
constexpr int kSubscribe = 6;
constexpr int kLinger = 17;
constexpr int kReceiveLimit = 24;
constexpr int kLastEndpoint = 32;
constexpr int kRouterMandatory = 33;

struct Library {
  void* (*ctx_new)();
  int (*ctx_term)(void*);
  void* (*socket)(void*, int);
  int (*close)(void*);
  int (*setsockopt)(void*, int, const void*, std::size_t);
  int (*getsockopt)(void*, int, void*, std::size_t*);
  int (*bind)(void*, const char*);
  int (*connect)(void*, const char*);
  int (*send)(void*, const void*, std::size_t, int);
  int (*msg_init)(Part*);
  int (*msg_recv)(Part*, void*, int);
  void* (*msg_data)(Part*);
  std::size_t (*msg_size)(const Part*);
  int (*msg_more)(const Part*);
  int (*msg_close)(Part*);
  int (*poll)(PollItem*, int, long);
  int (*last_error)();
  const char* (*strerror)(int);
};

[[noreturn]] void fail(std::string_view what) {
  throw ConfigError(fmt::format("backend 'gazebo' needs ZeroMQ 4: {}\n{}", what, kInstall));
}

template <typename Function>
void find(void* handle, Function& function, const char* name) {
  function = reinterpret_cast<Function>(::dlsym(handle, name));
  if (function == nullptr) fail(fmt::format("the library has no {}", name));
}

Library find_all() {
  void* handle = ::dlopen("libzmq.so.5", RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) fail(::dlerror());
  Library found{};
  find(handle, found.ctx_new, "zmq_ctx_new");
  find(handle, found.ctx_term, "zmq_ctx_term");
  find(handle, found.socket, "zmq_socket");
  find(handle, found.close, "zmq_close");
  find(handle, found.setsockopt, "zmq_setsockopt");
  find(handle, found.getsockopt, "zmq_getsockopt");
  find(handle, found.bind, "zmq_bind");
  find(handle, found.connect, "zmq_connect");
  find(handle, found.send, "zmq_send");
  find(handle, found.msg_init, "zmq_msg_init");
  find(handle, found.msg_recv, "zmq_msg_recv");
  find(handle, found.msg_data, "zmq_msg_data");
  find(handle, found.msg_size, "zmq_msg_size");
  find(handle, found.msg_more, "zmq_msg_more");
  find(handle, found.msg_close, "zmq_msg_close");
  find(handle, found.poll, "zmq_poll");
  find(handle, found.last_error, "zmq_errno");
  find(handle, found.strerror, "zmq_strerror");
  return found;
}

const Library& library() {
  static const Library found = find_all();  // tried again by the next call where it throws
  return found;
}

void check(bool good, std::string_view what) {
  if (!good) {
    throw ConnectionError(fmt::format("ZeroMQ: {}: {}", what, library().strerror(library().last_error())));
  }
}

}  // namespace

void load() { (void)library(); }

Context::Context() : context_(library().ctx_new()) { check(context_ != nullptr, "a context"); }

Context::~Context() { library().ctx_term(context_); }

Socket::Socket(const Context& context, Kind kind) : socket_(library().socket(context.get(), static_cast<int>(kind))) {
  check(socket_ != nullptr, "a socket");
  const auto set = [this](int option, int value) { library().setsockopt(socket_, option, &value, sizeof value); };
  set(kLinger, 0);
  set(kReceiveLimit, 0);  // none: a thread of ours takes messages as they come
  if (kind == Kind::router) set(kRouterMandatory, 1);
}

Socket::~Socket() { library().close(socket_); }

void Socket::set_identity(std::string_view name) {
  check(library().setsockopt(socket_, kIdentity, name.data(), name.size()) == 0, "an identity");
}

std::string Socket::bind(const std::string& ip) {
  check(library().bind(socket_, fmt::format("tcp://{}:*", ip).c_str()) == 0, fmt::format("listening at {}", ip));
  std::array<char, 256> endpoint{};
  std::size_t size = endpoint.size() - 1;
  check(library().getsockopt(socket_, kLastEndpoint, endpoint.data(), &size) == 0, "an address");
  return endpoint.data();
}

void Socket::connect(const std::string& address) {
  check(library().connect(socket_, address.c_str()) == 0, fmt::format("connecting to '{}'", address));
}

void Socket::subscribe(std::string_view prefix) {
  check(library().setsockopt(socket_, kSubscribe, prefix.data(), prefix.size()) == 0, "a subscription");
}

bool Socket::send(std::span<const std::string_view> frames) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int more = i + 1 < frames.size() ? kSendMore : 0;
    if (library().send(socket_, frames[i].data(), frames[i].size(), kDoNotWait | more) < 0) return false;
  }
  return true;
}

Frames Socket::receive() {
  Frames frames;
  for (bool more = true; more;) {
    Part part{};
    library().msg_init(&part);
    if (library().msg_recv(&part, socket_, kDoNotWait) < 0) {
      library().msg_close(&part);
      return {};
    }
    frames.emplace_back(static_cast<const char*>(library().msg_data(&part)), library().msg_size(&part));
    more = library().msg_more(&part) != 0;
    library().msg_close(&part);
  }
  return frames;
}

void poll(std::span<PollItem> items, int milliseconds) {
  library().poll(items.data(), static_cast<int>(items.size()), milliseconds);
}

}  // namespace threewe::gazebo::zmq
