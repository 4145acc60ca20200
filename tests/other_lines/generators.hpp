// Captures of other protocols than BiSS C, each as its devices make it; facts from public
// documents.
#pragma once

#include "tests/other_lines/drawing.hpp"

namespace biss::other_lines {

// Encoders.
Drawing draw_ssi(Dice& dice);
Drawing draw_endat(Dice& dice);
Drawing draw_dsl(Dice& dice);
Drawing draw_tamagawa(Dice& dice);
Drawing draw_nikon(Dice& dice);
Drawing draw_quadrature(Dice& dice);

// Boards and buses.
Drawing draw_spi(Dice& dice);
Drawing draw_i2c(Dice& dice);
Drawing draw_uart(Dice& dice);
Drawing draw_modbus(Dice& dice);
Drawing draw_pwm(Dice& dice);

// Nothing to read.
Drawing draw_clock_alone(Dice& dice);
Drawing draw_noise(Dice& dice);
Drawing draw_idle(Dice& dice);

}  // namespace biss::other_lines
