// ZeroMQ, over which Gazebo's messages travel: its functions, found in its library when they are first needed. Its
// binary interface has been the same throughout version 4, so that its headers are not needed to compile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gazebo/protobuf.hpp"

namespace threewe::gazebo::zmq {

/// What installs the library, on Debian and Ubuntu; Gazebo itself needs it.
inline constexpr const char* kInstall = "apt install libzmq5";

/// What `poll` waits for: a socket, or a file descriptor where `socket` is null.
struct PollItem {
  void* socket = nullptr;
  int descriptor = 0;
  short events = 1;  // readable
  short found = 0;
};

enum class Kind : int { publisher = 9, subscriber = 2, router = 6 };  // XPUB, SUB, ROUTER
using Frames = std::vector<std::string>;

/// Loads the library once; it stays. Throws ConfigError, naming the package to install, where it is not there.
void load();

/// What sockets belong to; outlives them.
class Context {
 public:
  Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context();
  void* get() const { return context_; }

 private:
  void* context_;
};

/// One socket, for one thread at a time.
class Socket {
 public:
  Socket(const Context& context, Kind kind);
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket();
  void* get() const { return socket_; }

  /// How others address it, before it is bound.
  void set_identity(std::string_view name);
  /// Binds it to a free port of an address, and returns where: "tcp://192.0.2.1:40000". Throws ConnectionError.
  std::string bind(const std::string& ip);
  /// Throws ConnectionError for what is no address.
  void connect(const std::string& address);
  /// A subscriber receives messages whose first frame begins so.
  void subscribe(std::string_view prefix);
  /// All frames of one message. False where a router does not know, or not yet, whom the first frame names.
  bool send(std::span<const std::string_view> frames);
  /// One message that has arrived; empty where none has.
  Frames receive();

 private:
  void* socket_;
};

/// Waits until one of them can be read, for at most that long [wall].
void poll(std::span<PollItem> items, int milliseconds);

}  // namespace threewe::gazebo::zmq
