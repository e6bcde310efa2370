// The early depth pass: nothing but depths.
void main() {
}
