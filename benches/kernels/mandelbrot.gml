% The Mandelbrot set, up to 30 iterations, on [-2.2, 0.8] x [-1.2, 1.2].
{ /v /u /face
  u 3.0 mulf 2.2 subf /cr
  v 2.4 mulf 1.2 subf /ci
  { /orbit /n /im /re
    n 30 lessi
    { re re mulf /rr
      im im mulf /ii
      rr ii addf 4.0 lessf
      { rr ii subf cr addf
        re im mulf 2.0 mulf ci addf
        n 1 addi orbit orbit apply }
      { n } if }
    { n } if } /orbit
  0.0 0.0 0 orbit orbit apply
  real 30.0 divf /t
  t
  t t mulf
  1.0 t subf
  point 0.9 0.1 10.0 }
