// The density that a desktop tells its programs, as X11 has it.
#pragma once

namespace voxcone {

/// While it lives, programs that ask the display are told `dpi` dots an inch; 96 is a content scale of 1.
class DisplayDensity {
  public:
    explicit DisplayDensity(int dpi);
    ~DisplayDensity();
    DisplayDensity(const DisplayDensity&) = delete;
    DisplayDensity& operator=(const DisplayDensity&) = delete;

  private:
    void* display_;
};

}  // namespace voxcone
