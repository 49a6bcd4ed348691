% mandelbrot.gml - the Mandelbrot set woven into a carpet, two chrome balls on it (Chicago).
%
% For every point of the plane that shows, the surface function iterates z = z^2 + c until z
% leaves the circle of radius 2: a loop written as a recursion in tail position, which costs
% no stack. The inside of the set is polished: the diffuse share depends on the place too.

#include "lib/surfaces.ins"
#include "lib/build.ins"

80 /limit

% c steps -> integer: how many steps it takes to escape, `limit` if it never does
{ /cy /cx
  { /go /n /y /x
    x x mulf /xx
    y y mulf /yy
    n limit eqi { true } { 4.0 xx yy addf lessf } if
      { n }
      { xx yy subf cx addf  x y mulf 2.0 mulf cy addf  n 1 addi  go go apply }
    if
  } /go
  0.0 0.0 0 go go apply
} /steps

% angle wave -> real: a sine between 0 and 1
{ sin 0.5 mulf 0.5 addf } /wave

{ /v /u /face
  u v steps apply /n
  n limit eqi
    { 0.01 0.01 0.03 point 0.6 0.4 80.0 }
    { n real 1.0 addf sqrt 78.0 mulf 40.0 subf /a            % the bands close up as n grows
      1.0 n 2 modi real 0.14 mulf subf /shade               % every other band is darker
      a 175.0 subf wave apply shade mulf
      a 130.0 subf wave apply 0.8 mulf 0.04 addf shade mulf
      a 20.0 subf wave apply 0.6 mulf 0.25 addf shade mulf
      point 0.95 0.05 30.0
    }
  if
} /fractal

0.85 mirror apply /chrome

% A sky for the chrome to reflect. Chicago reflections are not tinted by the metal.
{ /v /u /face
  v 2.0 mulf 1.0 subf clampf /h
  1.0 h subf 0.9 mulf  0.55 h 0.2 mulf subf  0.35 h 0.5 mulf addf  point 2.0 0.0 1.0
} /sky

fractal plane
chrome sphere 0.24 uscale 0.42 0.24 -0.62 translate union
chrome sphere 0.16 uscale -1.55 0.16 0.55 translate union
0.68 0.0 0.05 translate -52.0 rotatex 0.0 -0.05 1.68 translate
sky 60.0 dome apply union /carpet

0.35 0.35 0.35 point
[ -2.0 3.0 -1.0 point  1.1 1.05 0.95 point  pointlight ]
1.0 0.0 0.02 point
carpet 3 60.0 320 240 "mandelbrot.ppm" render
