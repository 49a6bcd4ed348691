% Marble: a coarse and a fine wave bend the veins, a fourth wave clouds the stone.
% 55 operators, four of them sin or cos.
{ /v /u /face
  u 6.0 mulf /x
  v 4.0 mulf /y
  x 67.0 mulf y 31.0 mulf addf sin /coarse
  y 113.0 mulf x 47.0 mulf subf coarse 40.0 mulf addf cos /fine
  x y addf 90.0 mulf coarse 75.0 mulf addf fine 25.0 mulf addf sin /wave
  1.0 wave wave mulf subf /calm
  calm calm mulf /square
  square square mulf /vein
  x y subf 130.0 mulf fine 60.0 mulf addf cos 0.5 mulf 0.5 addf /cloud
  cloud cloud mulf 3.0 cloud 2.0 mulf subf mulf /soft
  vein 0.7 mulf soft 0.3 mulf addf clampf /t
  1.0 t subf /rest
  t 0.92 mulf rest 0.20 mulf addf
  t 0.88 mulf rest 0.16 mulf addf
  t 0.80 mulf rest 0.24 mulf addf
  point
  t 0.35 mulf 0.55 addf
  0.45 t 0.25 mulf subf
  t 18.0 mulf 6.0 addf }
