// Each slider shows the left picture up to its position; a pointer over the pictures moves it too.
for (const figure of document.querySelectorAll(".wipe")) {
  const over = figure.querySelector(".over");
  const slider = figure.querySelector("input");
  const area = figure.querySelector("div");
  const show = () => { over.style.clipPath = `inset(0 ${100 - slider.value}% 0 0)`; };
  slider.addEventListener("input", show);
  area.addEventListener("pointermove", (event) => {
    const box = area.getBoundingClientRect();
    slider.value = Math.round((100 * (event.clientX - box.left)) / box.width);
    show();
  });
  show();
}
