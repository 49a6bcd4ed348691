% A cloud of n spheres in a cube: spread evenly, of one surface, and the smaller the more there are,
% so that they always fill the same share of it.
{ /v /u /face 0.9 0.6 0.3 point 0.8 0.0 1.0 } sphere /ball

% 0.6 of the side of the cube over the cube root of n, by Newton's method.
n real /count
{ /self /i /root
  i 0 eqi { root } {
    root 2.0 mulf count root root mulf divf addf 3.0 divf  i 1 subi  self self apply
  } if
} /newton
0.6 count 60 newton newton apply divf /radius

% The fractional parts of multiples of the powers of 1 / 1.2207..., the root of x^4 = x + 1, fill a
% cube evenly (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
{ /step /i i real step mulf frac 2.0 mulf 1.0 subf } /spread
{ /self /i /all
  i n eqi { all } {
    all
    ball radius uscale
    i 0.8191725133961645 spread apply
    i 0.6710436067037893 spread apply
    i 0.5497004779019703 spread apply translate
    union
    i 1 addi self self apply
  } if
} /fill
ball radius uscale 1 fill fill apply  0.0 0.0 2.8 translate /cloud

0.3 0.3 0.3 point
[ 1.0 -1.0 1.0 point 0.9 0.9 0.9 point light ]
cloud 0 60.0 320 240 "spheres.ppm" render
