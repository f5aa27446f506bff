for (const button of document.querySelectorAll("button.copy"))
  button.addEventListener("click", () => {
    getSelection().selectAllChildren(button.previousElementSibling);
    document.execCommand("copy");
    button.textContent = "copied";
  });
