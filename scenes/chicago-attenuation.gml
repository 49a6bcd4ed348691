% chicago-attenuation.gml - what the Chicago dialect does with light (Chicago dialect).
%
% `render` takes one more operand, the point attn = (a0, a1, a2): light from a lamp fades with
% distance d as 1 / (a0 + a1 d + a2 d^2), here so soon that each lamp has only its own part of
% the colonnade. Highlights are not tinted: on the saturated balls they have the colour of the
% lamp. What a mirror reflects is clamped to white first, even the panel at the far end,
% which is brighter than white. The depth counts the first ray.

#include "lib/surfaces.ins"
#include "lib/build.ins"

0.85 0.83 0.8 point matte apply /limestone
0.9 0.02 0.03 point 0.6 0.3 120.0 plain apply /red
0.02 0.55 0.1 point 0.6 0.3 120.0 plain apply /green
0.03 0.1 0.85 point 0.6 0.3 120.0 plain apply /blue
0.0 0.0 0.0 point 0.0 0.85 300.0 plain apply /black-glass
14.0 12.0 8.0 point matte apply /panel

[ red green blue ] /dyes

% i pair -> object: two columns, and two balls in front of them
{ /i
  limestone cylinder 0.26 3.2 0.26 scale
  limestone cube -0.5 0.0 -0.5 translate 0.7 0.18 0.7 scale union
  limestone cube -0.5 0.0 -0.5 translate 0.7 0.18 0.7 scale 0.0 2.4 0.0 translate union
  dyes i 3 modi get sphere 0.3 uscale 0.75 0.3 -0.65 translate union /left
  left -2.1 0.0 0.0 translate
  left -1.0 1.0 1.0 scale 2.1 0.0 0.0 translate union            % its mirror image
  0.0 0.0 i real 2.4 mulf translate
} /pair

6 pair repeat apply
limestone cube -0.5 0.0 0.0 translate 6.0 0.5 20.0 scale 0.0 2.58 -3.0 translate union
black-glass sphere 0.55 uscale 0.0 0.55 2.2 translate union
panel cube -0.5 0.0 0.0 translate 1.6 2.2 0.1 scale 0.0 0.0 15.2 translate union
0.16 0.15 0.17 point 0.5 0.48 0.45 point 0.3 checker apply plane
  0.7 uscale 45.0 rotatey union
0.0 -1.25 3.0 translate /colonnade

0.13 0.13 0.17 point
[ -0.6 0.9 1.7 point   1.9 1.3 0.75 point  pointlight
   0.0 1.0 6.5 point   0.6 1.6 1.8 point  pointlight
   0.0 1.0 11.5 point  2.0 0.7 1.6 point  pointlight ]
1.0 0.05 0.11 point
colonnade 5 68.0 320 240 "chicago-attenuation.ppm" render
