% Functions that call themselves, or what they were given as themselves, in tail position.
{ /f /n /b /a n 0 eqi { a } { b a b addi n 1 subi f f apply } if } /fib 0 1 30 fib fib apply %! 832040
{ /f /n /b /a n 0 eqi { a b } { b a n 1 subi f f apply } if } /swap 1 2 5 swap swap apply %! 2 1
{ /f /n /c /b /a n 0 eqi { a b c } { b c a n 1 subi f f apply } if } /turn 1 2 3 4 turn turn apply %! 2 3 1
{ /f /n /b /a n 0 eqi { a getz } { b a n 1 subi f f apply } if } /swap 1.0 2.0 3.0 point 4.0 5.0 6.0 point 3 swap swap apply %! 6.0
{ /k { /f /n /x n 0 eqi { x } { x k mulf n 1 subi f f apply } if } /loop 1.0 3 loop loop apply } /cube-of 2.0 cube-of apply %! 8.0
{ /k { /f /n /x n 0 eqi { x } { k n 1 subi f f apply } if } /loop 1.0 2 loop loop apply } /g 5.0 g apply %! 5.0
{ /k { /f /n /s n 0 eqi { s apply } { { s apply k addi } n 1 subi f f apply } if } /loop { 0 } /zero zero 3 loop loop apply } /g 7 g apply %! 21
{ /f /n n 0 eqi { 1 } { n 1 subi f f apply } if } /one { /f /n n 10 addi } /two 3 two one apply %! 12
{ /f /n /y /x x x mulf y y mulf addf 100.0 lessf { x 2.0 mulf y 1.0 addf n 1 addi f f apply } { x y n } if } /grow 1.0 0.0 0 grow grow apply %! 16.0 4.0 4
{ /f /n /x n 0 eqi { x } { x 1.5 addf /y n n 1 subi f f apply } if } /loop 0.5 3 loop loop apply %! error E0201 at 34
{ /x /y x x mulf y y mulf addf } /norm 1 2.0 norm apply %! error E0201 at 22
{ /f /n n 9223372036854775806 addi f f apply } /up 1 up up apply %! error E0301 at 31
