% One program a line, and behind `%!` the stack it leaves, or `error CODE at COLUMN`.
1 /x { x } /f 2 /x f apply x addi %! 3
{ /x x x } /dup 3 dup apply addi %! 6
{ /self /n n 2 lessi { 1 } { n 1 subi self self apply n muli } if } /fact 12 fact fact apply %! 479001600
{ /self /n n 2 lessi { n } { n 1 subi self self apply n 2 subi self self apply addi } if } /fib 20 fib fib apply %! 6765
{ /self /n n 0 eqi { 42 } { n 1 subi self self apply } if } /down 25000 down down apply %! 42
{ /self /n n 0 eqi { 0 } { n 1 subi self self apply 1 addi } if } /up 25000 up up apply %! 25000
1 2 3 { addi } apply %! 1 5
true { 1 } { 2 } if false { 1 } { 2 } if %! 1 2
1 true { 2 } { 3 4 } if %! 1 2
1 false { 2 } { 3 4 } if %! 1 3 4
{ 1 } { 2 } /b /a true a b if false a b if %! 1 2
true { 1 } /a a { 2 } if %! 1
1 2 lessi { 10 } { 20 } if %! 10
{ /c c { /x x 1 addi } { /x x 1 subi } if } /step 5 true step apply 5 false step apply %! 6 4
{ /c 1 2 c { addi } { subi } if } /g true g apply false g apply %! 3 -1
{ /c c { 7 } { 1 2 } if } /h true h apply false h apply %! 7 1 2
{ /c 1 c { /y y y } { 5 /y y 9 } if } /k true k apply false k apply %! 1 1 1 5 9
{ /a { /b { /c a b addi c addi } } } /curry 3 2 1 curry apply apply apply %! 6
1 /x { 2 /x x } apply x %! 2 1
true { 2 /x x } { } if x %! error E0102 at 24
x %! error E0102 at 1
true { } { 5 0 divi x } if %!
{ y } /f 1 /y f apply %! error E0102 at 3
{ /f f f apply } /omega 1 %! 1
1 apply %! error E0201 at 3
apply %! error E0101 at 1
1 { 1 } { 2 } if %! error E0201 at 15
true 1 { 2 } if %! error E0201 at 14
true { 2 } 1 if %! error E0201 at 14
{ 1 } { 2 } if %! error E0101 at 13
/x %! error E0101 at 1
{ /x } apply %! error E0101 at 3
{ /a /b a b subi } /rsub 1 10 rsub apply %! 9
{ /n { /m m n muli } } /mul 6 7 mul apply apply %! 42
0 /zero { zero } /get-zero 1 /zero get-zero apply %! 0
{ } apply %!
{ { 1 } } apply apply %! 1
1.5 /x { x x mulf } apply { x } apply %! 2.25 1.5
{ /b /a a b lessf { a } { b } if } /min 1.0 2.0 min apply 3.0 2.0 min apply %! 1.0 2.0
{ /v v getx v gety v getz } /parts 1.0 2.0 3.0 point parts apply %! 1.0 2.0 3.0
{ /p p 0.0 lessf { true } { false } if { 1 } { 2 } if } /q -1.0 q apply 1.0 q apply %! 1 2
{ 1 { 2 { 3 { 4 { 5 } apply } apply } apply } apply } apply %! 1 2 3 4 5
{ /self /n /acc n 0 eqi { acc } { acc n addi n 1 subi self self apply } if } /sum 0 100 sum sum apply %! 5050
